#include "ecology/trust/realm.h"

#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <stdexcept>

#include "ecology/trust/measurements.h"
#include "trust/operations.h"
#include "trust/rights/rights_judge.h"
#include "trust/trust.h"

namespace rubicon::bench::trust {

namespace {

std::filesystem::path new_folder() {
  auto name = (std::filesystem::temp_directory_path() / "rubicon-bench-XXXXXX").string();
  if (::mkdtemp(name.data()) == nullptr) give_up("no folder " + name);
  return name;
}

}  // namespace

Realm::Realm() : parent_(new_folder()) {
  const auto now = std::chrono::time_point_cast<WallTime::duration>(std::chrono::system_clock::now());
  if (auto made = rubicon::trust::init(folder(), {"Bench", {}}, now); !made) give_up(made.error().text);
}

Realm::~Realm() {
  std::error_code ignored;
  std::filesystem::remove_all(parent_, ignored);
}

void add_to(tuples::dds::DdsOptions& options, const std::string& folder, base::Scheduler& scheduler,
            base::LogSink& log) {
  auto opened =
      rubicon::trust::Trust::open({folder, rubicon::trust::kLocalMember, {}, {}}, scheduler, Log(log, "trust"));
  if (!opened) throw std::runtime_error(opened.error().text);
  options.trust = std::move(*opened);
  options.judge = std::make_shared<rubicon::trust::rights::RightsJudge>(rubicon::trust::rights::Rights());
}

}  // namespace rubicon::bench::trust
