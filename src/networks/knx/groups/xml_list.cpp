#include <fmt/format.h>

#include "networks/knx/groups/encoding.h"
#include "networks/knx/groups/group_list.h"
#include "networks/knx/groups/group_list_builder.h"
#include "networks/knx/xml/xml_parser.h"
#include "rubicon/key.hpp"

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::string_view kRefused = ": file refused, nothing imported";

/// The notation of a document, from its first addresses.
wire::Notation xml_notation(std::string_view text) {
  constexpr std::string_view kAttribute = " Address=\"";
  NotationDetector vote;
  std::size_t at = text.find(kAttribute);
  for (int i = 0; i < 1000 && at != text.npos; ++i, at = text.find(kAttribute, at)) {
    at += kAttribute.size();
    vote.add(text.substr(at, std::min<std::size_t>(text.find('"', at) - at, 40)), true);
  }
  return vote.winner();
}

bool yes(const xml::Attributes& attributes, std::string_view name) {
  const auto small = to_lower(attributes.text(name));
  return small == "true" || small == "1";
}

/// Builds the list from the elements of the document.
class XmlList final : public xml::Listener {
 public:
  XmlList(GroupList& list, wire::Notation notation)
      : list_(list),
        parser_(*this, {32, &encoding, "UTF-8, UTF-16, ISO-8859-1 or Windows-1252"}),
        builder_(list, notation) {}

  Result<void> read(std::string_view text) {
    auto read = parser_.feed(text);
    return read ? parser_.finish() : read;
  }
  std::size_t line() const { return parser_.line(); }

  void start(std::string_view name, const xml::Attributes& attributes) override {
    if (++depth_ == 1) {
      if (name != "GroupAddress-Export")
        parser_.refuse(fmt::format("root element {}, expected GroupAddress-Export", model::quoted(name)));
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

  void end(std::string_view) override {
    if (!ranges_.empty() && ranges_.back().depth == depth_) ranges_.pop_back();
    --depth_;
  }

 private:
  struct Range {
    std::size_t depth;
    std::string name;
  };

  /// Windows-1252 is not among the encodings that Expat knows.
  static xml::Parser::SingleByte encoding(std::string_view name) {
    const auto small = to_lower(name);
    return small == "windows-1252" || small == "cp1252" ? &windows_1252 : nullptr;
  }

  void take(const xml::Attributes& attributes) {
    if (full_ || (full_ = builder_.full(line()))) return;
    const auto address = builder_.address(line(), attributes.text("Address"));
    if (!address) return;
    std::vector<std::string> changes;
    GroupEntry entry;
    entry.line = line();
    entry.address = *address;
    entry.name = builder_.field("name", attributes.text("Name"), changes);
    entry.description = builder_.field("description", attributes.text("Description"), changes);
    entry.central = yes(attributes, "Central");
    entry.unfiltered = yes(attributes, "Unfiltered");
    if (const auto security = attributes.text("Security"); !security.empty()) entry.security = clean_text(security, 16);
    if (!ranges_.empty()) entry.main_group = ranges_.front().name;
    if (ranges_.size() > 1) entry.middle_group = ranges_.back().name;
    entry.dpt = builder_.type(attributes.text("DPTs"), changes);
    builder_.add(std::move(entry), changes);
  }

  GroupList& list_;
  xml::Parser parser_;
  GroupListBuilder builder_;
  std::vector<Range> ranges_;
  std::size_t depth_ = 0;
  bool full_ = false;
};

}  // namespace

GroupList read_xml(std::string_view text) {
  GroupList list;
  list.report.form = "ETS XML";
  if (text.size() > kMaxListBytes) {
    list.report.refuse(0, "no memory to read it");
    return list;
  }
  XmlList reader(list, xml_notation(text));
  if (const auto read = reader.read(text); !read) {
    list.entries.clear();
    const auto& why = read.error();
    list.report.refuse(reader.line(), why.text + (why.code == ErrorCode::kInvalid ? std::string(kRefused) : ""));
  } else if (list.entries.empty()) {
    list.report.warning(0, {}, "the file has no group address");
  }
  return list;
}

}  // namespace rubicon::networks::knx::groups
