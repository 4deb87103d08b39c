#include "networks/knx/keyring/keyring_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/bytes.h"
#include "base/text.h"
#include "networks/knx/xml/xml_parser.h"
#include "transport/transports.h"

namespace rubicon::networks::knx::keyring {

namespace {

constexpr std::size_t kKeyBlock = 16;
constexpr std::uint64_t kMaxSequence = (std::uint64_t{1} << 48U) - 1;
constexpr std::uint8_t kElementBegins = 1, kElementEnds = 2;
/// Each list of a keyring; real ones have some thousand entries.
constexpr std::size_t kMaxEntries = 100000;

/// For an error text: what a file holds may be long, and may control a terminal.
std::string shown(std::string_view value) {
  return base::one_line(value.substr(0, 40));
}

/// Builds the file from the elements. Every element counts for the signature, known or not.
class KeyringReader final : public xml::Listener {
 public:
  KeyringReader() : parser_(*this, {16}) {}

  Result<KeyringFile> read(std::string_view text) {
    auto read = parser_.feed(text);
    if (read) read = parser_.finish();
    if (!read) return fail(read.error().code, fmt::format("line {}: {}", parser_.line(), read.error().text));
    return std::move(file_);
  }

  void start(std::string_view name, const xml::Attributes& attributes) override {
    sign(name, attributes);
    path_.emplace_back(name);
    const auto read = element(name, attributes);
    if (!read) parser_.refuse(read.error().text);
  }

  void end(std::string_view) override {
    file_.signed_bytes.push_back(kElementEnds);
    path_.pop_back();
  }

 private:
  // The signature (knx.md, section 12).

  void sign(std::string_view text) {
    file_.signed_bytes.push_back(static_cast<std::uint8_t>(text.size() & 0xffU));
    file_.signed_bytes.insert(file_.signed_bytes.end(), text.begin(), text.end());
  }
  void sign(std::string_view name, const xml::Attributes& attributes) {
    file_.signed_bytes.push_back(kElementBegins);
    sign(name);
    std::vector<std::pair<std::string_view, std::string_view>> sorted;
    for (std::size_t i = 0; i < attributes.size(); ++i) {
      const auto attribute = attributes.at(i);
      const auto key = attribute.first;
      if (key != "Signature" && key != "xmlns" && !key.starts_with("xmlns:")) sorted.push_back(attribute);
    }
    std::sort(sorted.begin(), sorted.end());
    for (const auto& [key, value] : sorted) {
      sign(key);
      sign(value);
    }
  }

  // Elements.

  /// Only at its place an element has a meaning: the same name deeper in an unknown element has none.
  Result<void> element(std::string_view name, const xml::Attributes& attributes) {
    if (path_.size() == 1) return keyring(name, attributes);
    if (path_.size() == 2 && name == "Backbone") return backbone(attributes);
    if (path_.size() == 2 && name == "Interface") return interface(attributes);
    if (path_.size() != 3) return {};
    const auto& parent = path_[1];
    if (parent == "Interface" && name == "Group") return group(attributes);
    if (parent == "GroupAddresses" && name == "Group") return group_key(attributes);
    if (parent == "Devices" && name == "Device") return device(attributes);
    return {};
  }

  Result<void> keyring(std::string_view name, const xml::Attributes& attributes) {
    if (name != "Keyring")
      return fail(ErrorCode::kInvalid, fmt::format("root element '{}', expected Keyring", shown(name)));
    file_.project = attributes.text("Project");
    file_.created_by = attributes.text("CreatedBy");
    file_.created = attributes.text("Created");
    if (file_.created.empty()) return fail(ErrorCode::kInvalid, "Keyring has no attribute Created");
    return read_blocks(attributes, "Signature", file_.signature, true);
  }

  Result<void> backbone(const xml::Attributes& attributes) {
    KeyringFile::Backbone out;
    out.multicast = attributes.text("MulticastAddress");
    if (const auto text = attributes.find("Latency")) {
      const auto latency = base::parse_number<std::uint32_t>(*text);
      if (!latency || *latency < 1 || *latency > 8000)
        return fail(ErrorCode::kInvalid, fmt::format("Latency is '{}', expected 1 to 8000 (ms)", shown(*text)));
      out.latency = std::chrono::milliseconds(*latency);
    }
    auto read = read_blocks(attributes, "Key", out.key, false, kKeyBlock);
    if (read) file_.backbone = std::move(out);
    return read;
  }

  Result<void> interface(const xml::Attributes& attributes) {
    KeyringFile::Interface out;
    out.type = attributes.text("Type");
    if (auto read = read_address(attributes, "IndividualAddress", out.address); !read) return read;
    if (auto read = read_address(attributes, "Host", out.host); !read) return read;
    if (const auto text = attributes.text("UserID"); !text.empty()) {
      const auto user = base::parse_number<std::uint8_t>(text);
      if (!user || *user < 1 || *user > 127)
        return fail(ErrorCode::kInvalid, fmt::format("UserID is '{}', expected 1 to 127", shown(text)));
      out.user = *user;
    }
    if (auto read = read_blocks(attributes, "Password", out.password, false); !read) return read;
    if (auto read = read_blocks(attributes, "Authentication", out.authentication, false); !read) return read;
    return add(file_.interfaces, std::move(out));
  }

  Result<void> group(const xml::Attributes& attributes) {
    KeyringFile::Group out;
    if (auto read = read_group(attributes, out.address); !read) return read;
    auto senders = base::trimmed(attributes.text("Senders"));
    while (!senders.empty()) {
      const auto end = std::min(senders.find_first_of(" \t\r\n"), senders.size());
      const auto sender = wire::parse_individual(senders.substr(0, end));
      if (!sender) return fail(ErrorCode::kInvalid, fmt::format("Senders: {}", shown(sender.error().text)));
      out.senders.push_back(*sender);
      senders = base::trimmed(senders.substr(end));
    }
    return add(file_.interfaces.back().groups, std::move(out));
  }

  Result<void> group_key(const xml::Attributes& attributes) {
    KeyringFile::GroupKey out;
    if (auto read = read_group(attributes, out.address); !read) return read;
    if (auto read = read_blocks(attributes, "Key", out.key, true); !read) return read;
    return add(file_.group_keys, std::move(out));
  }

  Result<void> device(const xml::Attributes& attributes) {
    KeyringFile::Device out;
    if (auto read = read_address(attributes, "IndividualAddress", out.address); !read) return read;
    if (const auto text = attributes.text("SequenceNumber"); !text.empty()) {
      out.sequence = base::parse_number<std::uint64_t>(text);
      if (!out.sequence || *out.sequence > kMaxSequence)
        return fail(ErrorCode::kInvalid,
                    fmt::format("SequenceNumber is '{}', expected a number of 48 bits", shown(text)));
    }
    if (auto read = read_blocks(attributes, "ToolKey", out.tool_key, false, kKeyBlock); !read) return read;
    if (auto read = read_blocks(attributes, "ManagementPassword", out.management_password, false); !read) return read;
    if (auto read = read_blocks(attributes, "Authentication", out.authentication, false); !read) return read;
    return add(file_.devices, std::move(out));
  }

  // Attributes.

  template <class Entry>
  static Result<void> add(std::vector<Entry>& entries, Entry entry) {
    if (entries.size() >= kMaxEntries)
      return fail(ErrorCode::kOutOfRange, fmt::format("more than {} entries", kMaxEntries));
    entries.push_back(std::move(entry));
    return {};
  }

  /// Unchanged where there is none: USB interfaces have no host.
  static Result<void> read_address(const xml::Attributes& attributes, std::string_view name,
                                   wire::IndividualAddress& into) {
    const auto text = attributes.text(name);
    if (text.empty()) return {};
    const auto address = wire::parse_individual(text);
    if (!address) return fail(ErrorCode::kInvalid, fmt::format("{}: {}", name, address.error().text));
    into = *address;
    return {};
  }

  static Result<void> read_group(const xml::Attributes& attributes, wire::GroupAddress& into) {
    const auto address = wire::parse_group(attributes.text("Address"));
    if (!address) return fail(ErrorCode::kInvalid, fmt::format("Address: {}", address.error().text));
    into = *address;
    return {};
  }

  /// The value is base 64 of whole blocks; of one block where it must be there. The error text holds nothing of it.
  static Result<void> read_blocks(const xml::Attributes& attributes, std::string_view name, Bytes& into, bool required,
                                  std::size_t largest = 4096) {
    const auto text = attributes.text(name);
    if (text.empty() && !required) return {};
    const auto bytes = base::from_base64(text);
    if (!bytes) return fail(ErrorCode::kInvalid, fmt::format("{} is not base 64", name));
    if (bytes->empty() || bytes->size() % kKeyBlock != 0 || bytes->size() > (required ? kKeyBlock : largest))
      return fail(ErrorCode::kInvalid, fmt::format("{} has {} bytes, expected {}", name, bytes->size(),
                                                   required || largest == kKeyBlock ? "16" : "a multiple of 16"));
    const auto view = base::as_bytes(*bytes);
    into.assign(view.begin(), view.end());
    return {};
  }

  xml::Parser parser_;
  KeyringFile file_;
  std::vector<std::string> path_;
};

}  // namespace

Result<KeyringFile> parse_keyring(std::string_view text) {
  if (text.size() > kMaxKeyringBytes)
    return fail(ErrorCode::kOutOfRange,
                fmt::format("{} bytes, expected a keyring of at most {}", text.size(), kMaxKeyringBytes));
  return KeyringReader().read(text);
}

Result<KeyringFile> read_keyring(transport::Transports& transports, const std::string& path) {
  const auto text = transport::read_text(transports, path, kMaxKeyringBytes);
  if (!text) return fail(text.error());
  auto file = parse_keyring(*text);
  if (!file) return fail(file.error().code, fmt::format("{}: {}", path, file.error().text));
  return file;
}

}  // namespace rubicon::networks::knx::keyring
