#include "apps/simulators/script.h"

namespace rubicon::simulation {

std::vector<std::string_view> words_of(std::string_view line) {
  constexpr std::string_view kBlanks = " \t\r";
  std::vector<std::string_view> words;
  line = line.substr(0, line.find('#'));
  for (auto at = line.find_first_not_of(kBlanks); at != line.npos; at = line.find_first_not_of(kBlanks)) {
    line.remove_prefix(at);
    const auto end = std::min(line.find_first_of(kBlanks), line.size());
    words.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
  return words;
}

}  // namespace rubicon::simulation
