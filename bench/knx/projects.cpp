#include <malloc.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <random>
#include <stdexcept>

#include "frame/process_figures.h"
#include "knx/measurements.h"
#include "networks/knx/project/project.h"
#include "networks/knx/project/zip_source.h"
#include "support/knx_project.h"
#include "transport/local_transports.h"

namespace rubicon::bench::knx {

namespace {

using namespace networks::knx;

constexpr const char* kPassword = "flatpass";
constexpr const char* kPublicProject =
    RUBICON_SOURCE_DIR "/../shared/data/knx-secure/knxproj/xknx_test_project.knxproj";

std::string content_of(const char* path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

/// The median of the rounds, in milliseconds; `addresses` as many as it must give.
double import_ms(const std::string& content, const char* password, int rounds, std::size_t addresses) {
  const auto secret = secure::Secret::of_text(password);
  std::vector<double> took;
  for (int round = 0; round < rounds; ++round) {
    auto file = project::file_of(Bytes(content.begin(), content.end()));
    const auto start = Clock::now();
    const auto imported = project::import_project(std::move(file), "bench.knxproj", {&secret});
    took.push_back(seconds_since(start) * 1e3);
    if (!imported) throw std::runtime_error(imported.error().text);
    if (imported->report.taken != addresses) throw std::runtime_error("the project has lost addresses");
  }
  return rounded(median(took), 1);
}

std::string project_of(unsigned schema, const Plan& plan, const char* password) {
  auto house = support::large_house(schema, static_cast<unsigned>(plan.project_addresses), plan.program_bytes);
  house.password = password;
  return house.file();
}

/// A file of this many megabytes of application programs, and as many of a help file that no compression makes smaller.
std::string write_large(const Plan& plan) {
  constexpr unsigned kAddresses = 2000, kDevices = kAddresses / 16;
  const auto path =
      std::filesystem::temp_directory_path() / ("rubicon-bench-" + std::to_string(::getpid()) + ".knxproj");
  auto entries = support::large_house(23, kAddresses, plan.large_project_mb * 1'000'000 / kDevices).entries();
  std::mt19937_64 random(1);
  std::string help(plan.large_project_mb * 1'000'000, '\0');
  for (auto& byte : help) byte = static_cast<char>(random());
  entries.push_back({"M-00FA/Baggages/help.pdf", std::move(help)});
  std::ofstream(path, std::ios::binary) << support::zip_of(entries);
  return path.string();
}

void measure_large(const Plan& plan, Json& out) {
  const auto path = write_large(plan);
  out["large_project_file_mb"] = rounded(static_cast<double>(std::filesystem::file_size(path)) / 1e6, 0);
  ::malloc_trim(0);
  forget_peak();
  out["large_project_before_mb"] = rounded(resident_mb(), 1);
  transport::LocalTransports disk;
  const auto start = Clock::now();
  const auto imported = project::import_project(disk.open_file(path).value(), "bench.knxproj", {});
  out["large_project_ms"] = rounded(seconds_since(start) * 1e3, 0);
  out["large_project_peak_mb"] = rounded(peak_mb(), 1);
  std::filesystem::remove(path);
  if (!imported) throw std::runtime_error(imported.error().text);
}

}  // namespace

void measure_projects(const Plan& plan, Json& out) {
  const auto addresses = static_cast<std::size_t>(plan.project_addresses);
  auto& figures = out["project_ms"];
  figures["plain"] = import_ms(project_of(20, plan, ""), "", plan.rounds, addresses);
  figures["zipcrypto"] = import_ms(project_of(20, plan, kPassword), kPassword, plan.rounds, addresses);
  figures["aes"] = import_ms(project_of(23, plan, kPassword), kPassword, plan.rounds, addresses);
  const auto known = content_of(kPublicProject);
  if (known.empty()) {
    out["public_project_skipped"] = "no ../shared/data/knx-secure beside the source tree";
  } else {
    figures["xknx_test_project"] = import_ms(known, "test", plan.rounds, 19);
  }
  out["project_addresses"] = addresses;
  measure_large(plan, out);
}

}  // namespace rubicon::bench::knx
