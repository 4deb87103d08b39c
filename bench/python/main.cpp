// A client whose sets of one tuple are timed, one at a time, as rubicon-bench-python times those of the Python package:
//   rubicon-bench-client FOLDER OWNER KEY     prints the microseconds (p50) from a set to its reply

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <string>
#include <vector>

#include "rubicon/client.hpp"

namespace {

constexpr std::size_t kSets = 2000;

double microseconds_of_a_set(rubicon::Client& client, rubicon::OwnerId owner, const char* key) {
  std::vector<double> took;
  for (std::size_t one = 0; one < kSets; ++one) {
    const auto begin = std::chrono::steady_clock::now();
    bool replied = false;
    client.tuples().set_remote(owner, key, std::to_string(one), std::chrono::seconds(5),
                               [&replied](const rubicon::Reply&) { replied = true; });
    client.run_until([&replied] { return replied; }, std::chrono::seconds(10));
    took.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
  }
  std::nth_element(took.begin(), took.begin() + kSets / 2, took.end());
  return took[kSets / 2];
}

}  // namespace

int main(int count, char** words) {
  if (count != 4) return 2;
  rubicon::client::Options options;
  options.folder = words[1];
  auto client = rubicon::Client::open(options);
  if (!client) {
    std::fprintf(stderr, "%s\n", client.error().text.c_str());
    return 1;
  }
  const auto owner = static_cast<rubicon::OwnerId>(std::stoul(words[2]));
  const auto is_there = [&] { return std::ranges::count((*client)->tuples().peers(), owner) > 0; };
  if (!(*client)->run_until(is_there, std::chrono::seconds(10))) return 1;
  std::printf("%.1f\n", microseconds_of_a_set(**client, owner, words[3]));
}
