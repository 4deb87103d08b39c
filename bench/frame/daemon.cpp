#include "frame/daemon.h"

#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "frame/figures.h"
#include "frame/process_figures.h"

namespace rubicon::bench {

Daemon::Daemon(const std::string& yaml, std::uint32_t domain)
    : Daemon(yaml + fmt::format("tuples: {{interfaces: [lo], domain: {}}}\n", domain)) {}

Daemon::Daemon(const std::string& yaml) : folder_(std::filesystem::temp_directory_path() / "rubicon-bench-XXXXXX") {
  if (::mkdtemp(folder_.data()) == nullptr) throw std::runtime_error(folder_);
  const auto file = folder_ + "/island.yaml";
  std::ofstream(file) << yaml;
  process_ = std::make_unique<support::Process>(
      std::vector<std::string>{RUBICON_BINARY_DIR "/bin/rubicon-proxy", "run", file, "--log-level", "error"});
}

Daemon::~Daemon() {
  process_.reset();
  std::filesystem::remove_all(folder_);
}

double Daemon::processor() const {
  return processor_seconds(process_->pid());
}

double Daemon::resident_mb() const {
  return rounded(static_cast<double>(process_->resident_kilobytes()) * 1.024 / 1000, 1);
}

}  // namespace rubicon::bench
