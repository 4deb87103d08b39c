#include "networks/knx/xml/xml_parser.h"

#include <expat.h>
#include <fmt/format.h>
#include <malloc.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <utility>

namespace rubicon::networks::knx::xml {

namespace {

/// Expat takes the length of a piece as an int.
constexpr std::size_t kMaxPiece = std::size_t{1} << 20U;

std::string_view without_prefix(std::string_view name) {
  const auto colon = name.find(':');
  return colon == name.npos ? name : name.substr(colon + 1);
}

// NOLINTBEGIN(cppcoreguidelines-no-malloc): Expat takes functions like these.
void wipe_and_free(void* memory) {
  if (memory == nullptr) return;
  ::explicit_bzero(memory, ::malloc_usable_size(memory));
  std::free(memory);
}

void* move_to(void* memory, std::size_t size) {
  void* fresh = std::malloc(size);
  if (fresh == nullptr || memory == nullptr) return fresh;
  std::memcpy(fresh, memory, std::min(size, ::malloc_usable_size(memory)));
  wipe_and_free(memory);
  return fresh;
}
// NOLINTEND(cppcoreguidelines-no-malloc)

constexpr XML_Memory_Handling_Suite kWiped{std::malloc, move_to, wipe_and_free};

}  // namespace

std::optional<std::string_view> Attributes::find(std::string_view name) const {
  for (const auto* at = list_; at != nullptr && *at != nullptr; at += 2) {
    if (name == *at) return at[1];
  }
  return std::nullopt;
}

std::size_t Attributes::size() const {
  std::size_t count = 0;
  for (const auto* at = list_; at != nullptr && *at != nullptr; at += 2) ++count;
  return count;
}

/// What Expat calls.
struct Parser::Events {
  static Parser& of(void* user) { return *static_cast<Parser*>(user); }

  static void XMLCALL start(void* user, const XML_Char* name, const XML_Char** attributes) {
    of(user).start(name, Attributes(attributes));
  }
  static void XMLCALL end(void* user, const XML_Char* name) { of(user).end(name); }
  static void XMLCALL text(void* user, const XML_Char* bytes, int size) {
    if (!of(user).stopped_ && !of(user).enough_) of(user).listener_.text({bytes, static_cast<std::size_t>(size)});
  }
  static void XMLCALL document_type(void* user, const XML_Char*, const XML_Char*, const XML_Char*, int) {
    of(user).stop(ErrorCode::kRefused, "DOCTYPE not allowed: file refused, nothing read from disk");
  }
  static int XMLCALL encoding(void* user, const XML_Char* name, XML_Encoding* into) {
    const auto find = of(user).options_.encoding;
    const auto table = find == nullptr ? nullptr : find(name);
    if (table == nullptr) return XML_STATUS_ERROR;
    for (int i = 0; i < 256; ++i) into->map[i] = table(static_cast<std::uint8_t>(i));
    into->data = nullptr;
    into->convert = nullptr;
    into->release = nullptr;
    return XML_STATUS_OK;
  }
};

void Parser::Free::operator()(XML_ParserStruct* parser) const {
  XML_ParserFree(parser);
}

Parser::Parser(Listener& listener, Options options)
    : listener_(listener), options_(options), parser_(XML_ParserCreate_MM(nullptr, &kWiped, nullptr)) {
  if (!parser_) {
    stopped_ = Error{ErrorCode::kIo, "no memory to read it"};
    return;
  }
  XML_SetUserData(parser_.get(), this);
  XML_SetElementHandler(parser_.get(), Events::start, Events::end);
  XML_SetCharacterDataHandler(parser_.get(), Events::text);
  XML_SetStartDoctypeDeclHandler(parser_.get(), Events::document_type);
  XML_SetUnknownEncodingHandler(parser_.get(), Events::encoding, this);
  XML_SetParamEntityParsing(parser_.get(), XML_PARAM_ENTITY_PARSING_NEVER);
}

void Parser::stop(ErrorCode code, std::string why) {
  if (stopped_ || enough_) return;
  stopped_ = Error{code, std::move(why)};
  XML_StopParser(parser_.get(), XML_FALSE);
}

void Parser::refuse(std::string why) {
  stop(ErrorCode::kInvalid, std::move(why));
}

void Parser::enough() {
  if (stopped_ || enough_) return;
  enough_ = true;
  XML_StopParser(parser_.get(), XML_FALSE);
}

void Parser::start(std::string_view name, const Attributes& attributes) {
  if (stopped_ || enough_) return;
  if (++depth_ > options_.depth) return refuse(fmt::format("elements nested {} deep", depth_));
  listener_.start(without_prefix(name), attributes);
}

void Parser::end(std::string_view name) {
  if (stopped_ || enough_) return;
  --depth_;
  listener_.end(without_prefix(name));
}

std::size_t Parser::line() const {
  return parser_ ? static_cast<std::size_t>(XML_GetCurrentLineNumber(parser_.get())) : 0;
}

Error Parser::error() const {
  const auto code = XML_GetErrorCode(parser_.get());
  if (code == XML_ERROR_NO_ELEMENTS || code == XML_ERROR_UNCLOSED_TOKEN)
    return {ErrorCode::kInvalid, "document ends inside an element"};
  if (code == XML_ERROR_UNKNOWN_ENCODING)
    return {ErrorCode::kInvalid, fmt::format("its encoding is not known, expected {}", options_.known_encodings)};
  return {ErrorCode::kInvalid, fmt::format("not well-formed XML ({})", XML_ErrorString(code))};
}

Result<void> Parser::parse(std::string_view piece, bool last) {
  if (stopped_) return fail(*stopped_);
  if (enough_) return {};
  fed_ += piece.size();
  const auto status = XML_Parse(parser_.get(), piece.data(), static_cast<int>(piece.size()), last);
  if (enough_) return {};
  if (!stopped_ && status != XML_STATUS_OK) stopped_ = error();
  // Expat keeps the beginning of a tag until its end comes. Newer versions look for the end only once as much again has
  // come, and tell no place until then (-1): it is still the last one.
  if (const auto done = XML_GetCurrentByteIndex(parser_.get()); done >= 0) done_ = static_cast<std::uint64_t>(done);
  if (!stopped_ && fed_ - done_ > options_.longest_tag)
    stopped_ = Error{ErrorCode::kInvalid, fmt::format("a tag of more than {} bytes", options_.longest_tag)};
  if (stopped_) return fail(*stopped_);
  return {};
}

Result<void> Parser::feed(std::string_view piece) {
  while (!piece.empty()) {
    if (auto read = parse(piece.substr(0, kMaxPiece), false); !read) return read;
    piece.remove_prefix(std::min(piece.size(), kMaxPiece));
  }
  return {};
}

Result<void> Parser::finish() {
  return parse({}, true);
}

}  // namespace rubicon::networks::knx::xml
