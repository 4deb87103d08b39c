#include "tuples/dds/trust/member/guard_trust.h"

#include <dlfcn.h>

#include <filesystem>

#include "base/text.h"

namespace rubicon::tuples::dds {

namespace {

std::vector<std::string> split(std::string_view text, char at) {
  std::vector<std::string> parts;
  for (std::size_t begin = 0; begin <= text.size();) {
    const auto end = std::min(text.find(at, begin), text.size());
    parts.emplace_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
  return parts;
}

}  // namespace

std::vector<IdRange> ranges_of(std::string_view text) {
  std::vector<IdRange> ranges;
  for (const auto& one : split(text, ',')) {
    const auto ends = split(one, '-');
    if (ends.size() != 2) continue;
    ranges.push_back({base::parse_hex_number<std::uint32_t>(ends[0]).value_or(0),
                      base::parse_hex_number<std::uint32_t>(ends[1]).value_or(0)});
  }
  return ranges;
}

GuardTrust::GuardTrust(std::string folder, std::string guard, Member own)
    : folder_(std::move(folder)), guard_(std::move(guard)), own_(std::move(own)) {}

Result<DdsTrust::Documents> GuardTrust::documents() {
  const auto file = [this](const char* name) { return "file:" + folder_ + "/" + name; };
  if (!std::filesystem::exists(folder_ + "/certificate.pem"))
    return fail(ErrorCode::kNotFound, folder_ + "/certificate.pem: there is no such file, expected a certificate");
  if (::dlopen(guard_.c_str(), RTLD_NOW) != nullptr) begin_watch();
  take_revoked(laid_, {});
  if (is_revoked()) return fail(ErrorCode::kRefused, "the certificate of " + own_.name + " was revoked");
  return Documents{file("identity-ca.pem"), file("certificate.pem"), file("key.pem"),        file("permissions-ca.pem"),
                   file("governance.p7s"),  file("permissions.p7s"), std::to_string(papers_)};
}

void GuardTrust::begin_watch() {
  const auto watch = reinterpret_cast<decltype(&rubicon_guard_watch)>(symbol("rubicon_guard_watch"));
  if (watch == nullptr) return;
  watch(nullptr, &refused_);
  if (!refused_) return;
  watch(
      [](void* call, const std::uint8_t* prefix, const char* name, int is_verified, const char* reason) {
        GuidPrefix peer{};
        std::copy_n(prefix, peer.size(), peer.begin());
        (*static_cast<Refused*>(call))({peer, name, is_verified != 0, reason});
      },
      &refused_);
}

void GuardTrust::watch_refused(Refused call) {
  std::swap(refused_, call);  // the former one lives until it runs no more
  begin_watch();
}

/// nullptr until the library is loaded.
void* GuardTrust::symbol(const char* name) const {
  void* library = ::dlopen(guard_.c_str(), RTLD_NOW | RTLD_NOLOAD);
  if (library == nullptr) return nullptr;
  void* found = ::dlsym(library, name);
  ::dlclose(library);
  return found;
}

std::optional<Member> GuardTrust::who(const GuidPrefix& participant) const {
  const auto ask = reinterpret_cast<decltype(&rubicon_guard_who)>(symbol("rubicon_guard_who"));
  rubicon_guard_peer peer{};
  if (!sees_ || ask == nullptr || ask(participant.data(), &peer) != 1) return std::nullopt;
  Member member;
  member.name = peer.name;
  member.roles = split(peer.roles, ',');
  member.ids = ranges_of(peer.ids);
  member.serial = peer.serial;
  return member;
}

bool GuardTrust::meets_revoked() const {
  const auto ask = reinterpret_cast<decltype(&rubicon_guard_meets_revoked)>(symbol("rubicon_guard_meets_revoked"));
  return ask != nullptr && ask() == 1;
}

bool GuardTrust::is_revoked() const {
  const auto parts = split(list_, ':');
  const auto serials = split(parts.size() < 2 ? "" : parts[1], ',');
  return std::find(serials.begin(), serials.end(), own_.name) != serials.end();
}

bool GuardTrust::take_revoked(std::string_view signed_list, std::string_view) {
  ++lists_checked_;
  const auto parts = split(signed_list, ':');
  if (parts.size() != 3 || parts[2] != "signed") return false;
  const auto number = base::parse_number<unsigned long>(parts[0]).value_or(0);
  if (number <= number_) return false;
  number_ = number;
  list_ = signed_list;
  const auto serials = split(parts[1], ',');
  std::vector<const char*> names;
  for (const auto& one : serials) names.push_back(one.c_str());
  const auto revoke = reinterpret_cast<decltype(&rubicon_guard_revoke)>(symbol("rubicon_guard_revoke"));
  if (revoke != nullptr) revoke(names.data(), names.size());
  return true;
}

}  // namespace rubicon::tuples::dds
