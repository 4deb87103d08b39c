#pragma once

#include <map>
#include <optional>
#include <string>
#include <unordered_map>
#include <utility>

#include "networks/knx/project/document.h"
#include "networks/knx/project/installation.h"

namespace rubicon::networks::knx::project {

/// The number at the end of the namespace of a document: 11 is ETS 4, 12 to 20 ETS 5, 21 to 23 ETS 6 (knx.md, section
/// 13.4). Reads the first element only.
class SchemaDocument final : public Document {
 public:
  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view) override {}

  const std::string& name_space() const { return name_space_; }
  /// nullopt: the namespace is not one of http://knx.org/xml/project/.
  std::optional<unsigned> schema() const;

 private:
  std::string name_space_;
};

/// `project.xml`: the name, and how group addresses are written. It also has the password in plain text, which is not
/// kept.
class ProjectDocument final : public Document {
 public:
  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view) override {}

  const std::string& name() const { return name_; }
  wire::Notation notation() const { return notation_; }

 private:
  std::string name_;
  wire::Notation notation_ = wire::Notation::kThreeLevel;
};

/// `M-XXXX/Hardware.xml`: which application program a device has.
class HardwareDocument final : public KeepingDocument {
 public:
  explicit HardwareDocument(KeptTexts& texts) : KeepingDocument(texts) {}

  /// A Hardware2ProgramRefId, which must outlive this object.
  void want(std::string_view hardware_program) { programs_.try_emplace(hardware_program); }

  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view name) override;

  /// Of a wanted id; empty if it is not there.
  std::string_view program_of(std::string_view hardware_program) const;

 private:
  std::unordered_map<std::string_view, std::string_view> programs_;
  std::string hardware_program_;
};

/// An application program: the traits of the communication objects that a project uses, by the id of the reference, and
/// the names of the arguments of modules. Only what is wanted is kept, and reading ends with the last object of it.
class ProgramDocument final : public KeepingDocument {
 public:
  explicit ProgramDocument(KeptTexts& texts) : KeepingDocument(texts) {}

  // Ids must outlive this object.

  /// Also wants the object that the reference is of: the part of its id before `_R-`.
  void want(std::string_view reference);
  void want_argument(std::string_view id) { arguments_.try_emplace(id); }

  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view) override {}

  /// The traits of the reference over those of its object; nullopt if the program has neither.
  std::optional<ObjectTraits> traits_of(std::string_view reference) const;
  /// The name of a wanted argument of a module; empty = unknown.
  std::string_view argument_name(std::string_view id) const;

 private:
  struct Wanted {
    ObjectTraits traits;
    bool found = false;
  };
  using Objects = std::unordered_map<std::string_view, Wanted>;

  void take(Objects& wanted, const xml::Attributes& attributes);

  Objects references_, objects_;
  std::unordered_map<std::string_view, std::string_view> arguments_;
  std::size_t missing_ = 0;
};

/// `0.xml` once more: the values of the parameters whose text is part of the text of an object.
class ParameterDocument final : public KeepingDocument {
 public:
  explicit ParameterDocument(KeptTexts& texts) : KeepingDocument(texts) {}

  /// `id`: with the module, as the instance of the parameter has it. `device` must outlive this object.
  void want(std::string_view device, std::string_view id);

  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view name) override;

  /// Empty if the device has no value of its own.
  std::string_view value_of(std::string_view device, std::string_view id) const;
  bool wants_nothing() const { return values_.empty(); }

 private:
  std::map<std::pair<std::string_view, std::string_view>, std::string_view> values_;
  std::string device_;
};

}  // namespace rubicon::networks::knx::project
