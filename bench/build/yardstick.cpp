// What a processor is worth to a compiler now: `bench/build/measure` and `./run` time the compilation of this file,
// which uses the standard library as our files do. Change it and all multiples of it in bench/README.md are void.
#include <algorithm>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <unordered_map>
#include <variant>
#include <vector>

namespace yardstick {

template <int kNumber>
struct Part {
  using Value = std::variant<bool, long, double, std::string, std::vector<Part>>;
  Value value;
  std::map<std::string, Part> parts;
  std::unordered_map<int, std::function<std::optional<double>(const Part&)>> rules;

  std::string text() const {
    std::ostringstream out;
    std::visit(
        [&](const auto& one) {
          if constexpr (requires { out << one; }) out << one << kNumber;
        },
        value);
    for (const auto& [name, part] : parts) out << name << part.text();
    return out.str();
  }
  double sum() const {
    std::vector<double> all;
    for (const auto& [number, rule] : rules) {
      if (const auto found = rule(*this)) all.push_back(*found + number);
    }
    std::sort(all.begin(), all.end(), std::greater<>());
    double total = 0;
    for (const auto one : all) total += one;
    return total;
  }
};

template <int... kNumbers>
double all(std::integer_sequence<int, kNumbers...>) {
  return (Part<kNumbers>().sum() + ...) + static_cast<double>((Part<kNumbers>().text().size() + ...));
}

double run() {
  return all(std::make_integer_sequence<int, 12>());
}

}  // namespace yardstick
