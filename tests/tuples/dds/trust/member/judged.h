#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "rubicon/tuple_space.hpp"
#include "trust/rights/rights_judge.h"

namespace rubicon::tuples::dds {

/// What tests of rights ask a component that others are judged by, and what those answer.
class Judged {
 public:
  /// At first every member may do everything.
  static std::shared_ptr<trust::rights::RightsJudge> open_judge();

  Judged(TupleSpace& space, std::shared_ptr<trust::rights::RightsJudge> judge);
  /// `rules FILE`, `owns KEY`, `wanted KEY`; of the others `sees PATTERN`, `has ID KEY`, `try ID KEY`.
  void obey(const std::vector<std::string>& words);

 private:
  void take_rules(const std::string& file);

  TupleSpace& space_;
  std::shared_ptr<trust::rights::RightsJudge> judge_;
  std::vector<Handle> handles_;
  std::map<std::string, bool> wanted_;
};

}  // namespace rubicon::tuples::dds
