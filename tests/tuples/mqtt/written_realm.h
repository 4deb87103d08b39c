#pragma once

#include <functional>
#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "base/text.h"
#include "tuples/judge.h"

namespace rubicon::tuples::mqtt {

/// `signed 7 hall:1 desk:admin`: the seventh document. A number behind a name is that of its island, a word its role.
inline std::string document(int number, const std::string& members) {
  return "signed " + std::to_string(number) + " " + members;
}

/// Believes whatever begins with `signed`.
class WrittenRealm final : public UserRealm {
 public:
  explicit WrittenRealm(const std::string& first) { read(first); }

  std::shared_ptr<const Member> member(std::string_view user) const override {
    const auto found = members_.find(user);
    return found == members_.end() ? nullptr : found->second;
  }
  const std::string& document() const override { return document_; }
  Taken take(std::string_view text, std::string_view) override {
    ++taken;
    if (!text.starts_with("signed ")) return Taken::kWrong;
    if (std::stoi(std::string(text.substr(7))) <= number_) return Taken::kOlder;
    found(std::string(text));
    return Taken::kNewer;
  }
  Handle watch(std::function<void()> call) override {
    watches_.push_back(std::move(call));
    return {};
  }
  /// On the disk.
  void found(const std::string& text) {
    read(text);
    for (const auto& call : watches_) call();
  }
  int taken = 0;

 private:
  void read(const std::string& text) {
    document_ = text;
    std::istringstream words(text.substr(7));
    words >> number_;
    auto before = std::exchange(members_, {});
    for (std::string word; words >> word;) {
      Member one;
      const auto colon = word.find(':');
      one.name = word.substr(0, colon);
      one.ids.push_back({65536, 0xffffffff});
      const auto more = colon == word.npos ? std::string() : word.substr(colon + 1);
      if (const auto island = base::parse_number<std::uint32_t>(more)) one.ids.push_back({*island, *island});
      if (more == "admin") one.roles.emplace_back(more);
      auto& kept = before[one.name];
      members_[one.name] = kept && *kept == one ? kept : std::make_shared<Member>(one);
    }
  }

  std::string document_;
  int number_ = 0;
  std::map<std::string, std::shared_ptr<const Member>, std::less<>> members_;
  std::vector<std::function<void()>> watches_;
};

}  // namespace rubicon::tuples::mqtt
