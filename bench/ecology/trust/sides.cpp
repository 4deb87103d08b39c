#include "ecology/trust/sides.h"

#include "ecology/trust/realm.h"

namespace rubicon::bench::trust {

Sides Sides::measured(const Plan& plan, int rounds, const std::function<Json(const Meeting&)>& run) {
  const Realm realm;
  Sides sides;
  for (int turn = 0; turn < 2 * rounds; ++turn) {
    const bool secure = turn % 4 == 1 || turn % 4 == 2;
    auto meeting = plan.new_meeting();
    if (secure) meeting.trust = realm.folder();
    (secure ? sides.secure_ : sides.plain_).push_back(run(meeting));
  }
  return sides;
}

double Sides::median_of(const std::vector<Json>& rounds, const std::string& name) {
  std::vector<double> values;
  for (const auto& round : rounds) values.push_back(round.at(name));
  return median(values);
}

double Sides::ratio(const std::string& name) const {
  std::vector<double> ratios;
  for (std::size_t i = 0; i < plain_.size(); ++i)
    ratios.push_back(secure_[i].at(name).get<double>() / plain_[i].at(name).get<double>());
  return median(ratios);
}

Json Sides::figure(const std::string& name, int digits) const {
  return {{"plain", rounded(plain(name), digits)},
          {"secure", rounded(secure(name), digits)},
          {"ratio", rounded(ratio(name), 2)}};
}

}  // namespace rubicon::bench::trust
