#include "trust/chosen_member.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <tuple>
#include <vector>

#include "trust/issuer.h"
#include "trust/place.h"
#include "trust/revoked_list.h"
#include "trust/trust_folder.h"

namespace rubicon::trust {

namespace {

struct Candidate {
  std::string name;
  bool is_revoked = false, has_key = false, is_for_people = false;
  WallTime ends{};

  bool is_local() const { return name == kLocalMember; }
};

/// Empty if it cannot be read: Trust::open() says so.
RevokedList revoked_in(const TrustFolder& folder) {
  const auto papers = folder.realm_papers();
  if (!papers) return {};
  const auto signer = Certificate::of_pem(papers->permissions_ca.text, papers->permissions_ca.where);
  if (!signer) return {};
  auto list = read_revoked(papers->revoked.text, *signer, papers->revoked.where);
  return list ? std::move(*list) : RevokedList();
}

struct Candidates {
  std::vector<Candidate> all;
  std::optional<Error> damage;  ///< of a certificate that cannot be read
};

template <class Fits>
Candidates candidates_of(const TrustFolder& folder, Fits fits) {
  Candidates found;
  const auto revoked = revoked_in(folder);
  for (const auto& name : folder.members()) {
    const bool has_key = folder.files().exists(key_file(name));
    const bool is_for_people = folder.files().key_readers(key_file(name)) == KeyReaders::kPeople;
    const auto member = folder.member(name);
    if (!member) {
      found.damage = member.error();
      // Who uses it gets the error.
      if (name == kLocalMember && fits({name, {}, {}, {}, {}}))
        found.all.push_back({name, revoked.has_name(name), has_key, is_for_people, {}});
    } else if (fits(*member)) {
      found.all.push_back({name, revoked.find(member->serial) != nullptr, has_key, is_for_people, member->expires});
    }
  }
  return found;
}

}  // namespace

Result<std::string> choose_member_of_island(const std::filesystem::path& folder, OwnerId island) {
  const auto found = candidates_of(TrustFolder(folder), [island](const tuples::Member& member) {
    return is_island_member(member) && member.may_use(island);
  });
  const auto value = [](const Candidate& one) { return std::tuple(!one.is_revoked, one.has_key, one.ends); };
  const auto best = std::max_element(found.all.begin(), found.all.end(),
                                     [&](const auto& a, const auto& b) { return value(a) < value(b); });
  if (best != found.all.end()) return best->name;
  if (found.damage) return fail(*found.damage);
  return fail(
      ErrorCode::kNotFound,
      fmt::format(
          "{}: has no member with the id of island {}: on the host with the authority run `sudo rubicon "
          "trust dds init`; else `rubicon trust dds add NAME --island {}` there, and `sudo rubicon trust dds join` "
          "here",
          folder.string(), model::number(island), model::number(island)));
}

Result<std::string> choose_member_of_people(const std::filesystem::path& folder) {
  auto found =
      candidates_of(TrustFolder(folder), [](const tuples::Member& member) { return !is_island_member(member); });
  auto& all = found.all;
  std::erase_if(all, [](const Candidate& one) { return !one.has_key && !one.is_local(); });
  const auto standing = [](const Candidate& one) {
    return std::tuple(!one.is_revoked, one.is_local(), one.is_for_people);
  };
  std::sort(all.begin(), all.end(), [&](const auto& a, const auto& b) {
    return std::tuple(standing(a), a.ends) > std::tuple(standing(b), b.ends);
  });
  if (all.empty() && found.damage) return fail(*found.damage);
  if (all.empty())
    return fail(ErrorCode::kNotFound,
                fmt::format("{}: has no member for people: `rubicon trust dds join` takes one from its bundle",
                            folder.string()));
  if (all.size() > 1 && !all[0].is_revoked && standing(all[0]) == standing(all[1]))
    return fail(ErrorCode::kDuplicate,
                fmt::format("{}: has the members {} and {}: expected one, or one called {}", folder.string(),
                            std::min(all[0].name, all[1].name), std::max(all[0].name, all[1].name), kLocalMember));
  return all[0].name;
}

}  // namespace rubicon::trust
