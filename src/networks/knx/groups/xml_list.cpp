#include <expat.h>
#include <fmt/format.h>

#include <memory>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list_builder.h"
#include "networks/knx/groups/readers.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::size_t kMaxDepth = 32;
constexpr std::string_view kRefused = ": file refused, nothing imported";

using ParserPointer = std::unique_ptr<XML_ParserStruct, decltype(&XML_ParserFree)>;

/// The notation of a document, from its first addresses.
wire::Notation notation_of(std::string_view text) {
  constexpr std::string_view kAttribute = " Address=\"";
  NotationDetector vote;
  std::size_t at = text.find(kAttribute);
  for (int i = 0; i < 1000 && at != text.npos; ++i, at = text.find(kAttribute, at)) {
    at += kAttribute.size();
    vote.add(text.substr(at, std::min<std::size_t>(text.find('"', at) - at, 40)), true);
  }
  return vote.winner();
}

/// Attributes of an element by their names without a prefix.
class Attributes {
 public:
  explicit Attributes(const XML_Char** list) : list_(list) {}
  std::string_view text(std::string_view name) const {
    for (const auto** at = list_; at && *at; at += 2) {
      if (name == *at) return at[1];
    }
    return {};
  }
  bool yes(std::string_view name) const {
    const auto small = to_lower(text(name));
    return small == "true" || small == "1";
  }

 private:
  const XML_Char** list_;
};

/// Handles the events of the parser and builds the list.
class XmlList {
 public:
  XmlList(GroupList& list, XML_Parser parser, wire::Notation notation)
      : list_(list), parser_(parser), builder_(list, notation) {}

  std::size_t line() const { return static_cast<std::size_t>(XML_GetCurrentLineNumber(parser_)); }

  void start(std::string_view name, const Attributes& attributes) {
    if (const auto colon = name.find(':'); colon != name.npos) name.remove_prefix(colon + 1);
    if (++depth_ > kMaxDepth) return stop(fmt::format("elements nested {} deep{}", depth_, kRefused));
    if (depth_ == 1) {
      if (name != "GroupAddress-Export")
        stop(fmt::format("root element {}, expected GroupAddress-Export{}", model::quoted(name), kRefused));
      return;
    }
    if (name == "GroupRange") {
      std::vector<std::string> changes;
      ranges_.push_back({depth_, builder_.field("group name", attributes.text("Name"), changes)});
    } else if (name == "GroupAddress") {
      take(attributes);
    } else {
      list_.report.warning(line(), {}, fmt::format("element {} is not known: ignored", model::quoted(name)));
    }
  }

  void end() {
    if (!ranges_.empty() && ranges_.back().depth == depth_) ranges_.pop_back();
    --depth_;
  }

  void stop(std::string why) {
    if (!refused_) list_.report.refuse(line(), std::move(why));
    refused_ = true;
    XML_StopParser(parser_, XML_FALSE);
  }

  bool refused() const { return refused_; }

 private:
  struct Range {
    std::size_t depth;
    std::string name;
  };

  void take(const Attributes& attributes) {
    if (full_ || (full_ = builder_.full(line()))) return;
    const auto address = builder_.address(line(), attributes.text("Address"));
    if (!address) return;
    std::vector<std::string> changes;
    GroupEntry entry;
    entry.line = line();
    entry.address = *address;
    entry.name = builder_.field("name", attributes.text("Name"), changes);
    entry.description = builder_.field("description", attributes.text("Description"), changes);
    entry.central = attributes.yes("Central");
    entry.unfiltered = attributes.yes("Unfiltered");
    if (const auto security = attributes.text("Security"); !security.empty()) entry.security = clean_text(security, 16);
    if (!ranges_.empty()) entry.main_group = ranges_.front().name;
    if (ranges_.size() > 1) entry.middle_group = ranges_.back().name;
    entry.dpt = builder_.type(attributes.text("DPTs"), changes);
    builder_.add(std::move(entry), changes);
  }

  GroupList& list_;
  XML_Parser parser_;
  GroupListBuilder builder_;
  std::vector<Range> ranges_;
  std::size_t depth_ = 0;
  bool refused_ = false, full_ = false;
};

void XMLCALL on_start(void* user, const XML_Char* name, const XML_Char** attributes) {
  static_cast<XmlList*>(user)->start(name, Attributes(attributes));
}

void XMLCALL on_end(void* user, const XML_Char*) {
  static_cast<XmlList*>(user)->end();
}

void XMLCALL on_document_type(void* user, const XML_Char*, const XML_Char*, const XML_Char*, int) {
  static_cast<XmlList*>(user)->stop("DOCTYPE not allowed: file refused, nothing read from disk");
}

/// Windows-1252 is not among the encodings that Expat knows.
int XMLCALL on_encoding(void*, const XML_Char* name, XML_Encoding* info) {
  const auto small = to_lower(name);
  if (small != "windows-1252" && small != "cp1252") return XML_STATUS_ERROR;
  for (int i = 0; i < 256; ++i) info->map[i] = windows_1252(static_cast<std::uint8_t>(i));
  info->data = nullptr;
  info->convert = nullptr;
  info->release = nullptr;
  return XML_STATUS_OK;
}

std::string parse_error(XML_Parser parser) {
  const auto code = XML_GetErrorCode(parser);
  if (code == XML_ERROR_NO_ELEMENTS || code == XML_ERROR_UNCLOSED_TOKEN)
    return fmt::format("document ends inside an element{}", kRefused);
  if (code == XML_ERROR_UNKNOWN_ENCODING)
    return fmt::format("its encoding is not known, expected UTF-8, UTF-16, ISO-8859-1 or Windows-1252{}", kRefused);
  return fmt::format("not well-formed XML ({}){}", XML_ErrorString(code), kRefused);
}

}  // namespace

GroupList read_xml(std::string_view text) {
  GroupList list;
  list.report.form = "ETS XML";
  const ParserPointer parser(XML_ParserCreate(nullptr), &XML_ParserFree);
  if (!parser || text.size() > kMaxListBytes) {
    list.report.refuse(0, "no memory to read it");
    return list;
  }
  XmlList listener(list, parser.get(), notation_of(text));
  XML_SetUserData(parser.get(), &listener);
  XML_SetElementHandler(parser.get(), on_start, on_end);
  XML_SetStartDoctypeDeclHandler(parser.get(), on_document_type);
  XML_SetUnknownEncodingHandler(parser.get(), on_encoding, nullptr);
  XML_SetParamEntityParsing(parser.get(), XML_PARAM_ENTITY_PARSING_NEVER);
  const auto status = XML_Parse(parser.get(), text.data(), static_cast<int>(text.size()), XML_TRUE);
  if (listener.refused()) {
    list.entries.clear();
  } else if (status != XML_STATUS_OK) {
    list.entries.clear();
    list.report.refuse(listener.line(), parse_error(parser.get()));
  } else if (list.entries.empty()) {
    list.report.warning(0, {}, "the file has no group address");
  }
  return list;
}

}  // namespace rubicon::networks::knx::groups
