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
class HardwareDocument final : public Document {
 public:
  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view name) override;

  /// By Hardware2ProgramRefId; empty if it is not there.
  std::string program_of(const std::string& hardware_program) const;
  struct Product {
    std::string name, order_number;
  };
  /// By ProductRefId.
  Product product_of(const std::string& product) const;

 private:
  std::unordered_map<std::string, std::string> programs_;
  std::unordered_map<std::string, Product> products_;
  std::string hardware_program_;
};

/// An application program: the traits of the communication objects that a project uses, by the id of the reference, and
/// the names of the arguments of modules. Only what is wanted is kept, and reading ends with the last of it.
class ProgramDocument final : public Document {
 public:
  /// Also wants the object that the reference is of: the part of its id before `_R-`.
  void want(const std::string& reference);

  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view) override {}

  /// The traits of the reference over those of its object; empty ones if the program has neither.
  ObjectTraits traits_of(const std::string& reference) const;
  /// The name of an argument of a module; empty = unknown.
  std::string argument_name(const std::string& id) const;

 private:
  struct Wanted {
    ObjectTraits traits;
    bool found = false;
  };

  void take(std::unordered_map<std::string, Wanted>& wanted, const xml::Attributes& attributes);

  std::unordered_map<std::string, Wanted> references_, objects_;
  std::unordered_map<std::string, std::string> arguments_;
  std::size_t missing_ = 0;
};

/// `0.xml` once more: the values of the parameters whose text is part of the text of an object.
class ParameterDocument final : public Document {
 public:
  /// `id`: with the module, as the instance of the parameter has it.
  void want(const std::string& device, const std::string& id) { values_.try_emplace({device, id}); }

  void start(std::string_view name, const xml::Attributes& attributes) override;
  void end(std::string_view name) override;

  /// Empty if the device has no value of its own.
  std::string value_of(const std::string& device, const std::string& id) const;
  bool wants_nothing() const { return values_.empty(); }

 private:
  std::map<std::pair<std::string, std::string>, std::string> values_;
  std::string device_;
};

}  // namespace rubicon::networks::knx::project
