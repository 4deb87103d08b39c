#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>

#include "rubicon/result.hpp"

struct XML_ParserStruct;

namespace rubicon::networks::knx::xml {

/// The attributes of an element in the order of the file, with their values as UTF-8. Valid during the call that they
/// are passed to.
class Attributes {
 public:
  explicit Attributes(const char* const* list) : list_(list) {}

  /// nullopt if the element has no attribute of this name.
  std::optional<std::string_view> find(std::string_view name) const;
  /// The same; empty if there is none.
  std::string_view text(std::string_view name) const { return find(name).value_or(std::string_view()); }
  std::size_t size() const;
  /// Name and value.
  std::pair<std::string_view, std::string_view> at(std::size_t index) const {
    return {list_[2 * index], list_[2 * index + 1]};
  }

 private:
  const char* const* list_;  ///< name, value, name, value, ..., nullptr
};

/// What a document contains. Names of elements come without their prefix.
class Listener {
 public:
  virtual ~Listener() = default;
  virtual void start(std::string_view name, const Attributes& attributes) = 0;
  virtual void end(std::string_view name) = 0;
  /// Text between elements, in pieces of any size.
  virtual void text(std::string_view) {}
};

/// Reads an XML document of an outside file in pieces: no DOCTYPE, so no entities of its own, nothing is opened, and
/// the depth is bounded. Its memory is overwritten when it is freed: attributes of keyrings and projects have secrets.
class Parser {
 public:
  /// The code points of the 256 bytes of an encoding.
  using SingleByte = std::uint16_t (*)(std::uint8_t byte);
  struct Options {
    std::size_t depth = 32;  ///< of nested elements
    /// Encodings by their names as in the document, besides UTF-8, UTF-16, ISO-8859-1 and ASCII; nullptr = not known.
    SingleByte (*encoding)(std::string_view name) = nullptr;
    std::string_view known_encodings = "UTF-8, UTF-16 or ISO-8859-1";  ///< for the error text
    std::size_t longest_tag = std::size_t{8} << 20U;  ///< bytes of a tag with its attributes, or of a comment
  };

  /// The listener must outlive it.
  explicit Parser(Listener& listener) : Parser(listener, Options{}) {}
  Parser(Listener& listener, Options options);
  Parser(const Parser&) = delete;
  Parser& operator=(const Parser&) = delete;

  /// kInvalid: not well-formed, nested too deep, a tag too long, or refused by the listener; kRefused: it has a
  /// DOCTYPE. After an error every further call gives it again.
  Result<void> feed(std::string_view piece);
  /// The document ends here.
  Result<void> finish();
  /// Called by the listener: feed() then returns this error and the listener is not called again.
  void refuse(std::string why);
  /// Called by the listener that needs nothing more: it is not called again, and what follows is not examined.
  void enough();
  bool has_enough() const { return enough_; }
  /// Of the present event or the error, from 1.
  std::size_t line() const;

 private:
  struct Events;
  struct Free {
    void operator()(XML_ParserStruct* parser) const;
  };

  Result<void> parse(std::string_view piece, bool last);
  void stop(ErrorCode code, std::string why);
  void start(std::string_view name, const Attributes& attributes);
  void end(std::string_view name);
  Error error() const;

  Listener& listener_;
  Options options_;
  std::unique_ptr<XML_ParserStruct, Free> parser_;
  std::size_t depth_ = 0;
  std::uint64_t fed_ = 0;
  std::uint64_t done_ = 0;  ///< place of the last event in the document
  bool enough_ = false;
  std::optional<Error> stopped_;
};

}  // namespace rubicon::networks::knx::xml
