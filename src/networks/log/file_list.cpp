#include "networks/log/file_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/text.h"

namespace rubicon::networks::log {

namespace {

namespace fs = std::filesystem;

constexpr std::string_view kDigits = "0123456789";
constexpr std::size_t kMaxFiles = 100'000;

bool is_digit(char c) {
  return c >= '0' && c <= '9';
}

/// The digits at the front, without leading zeros.
std::string_view take_number(std::string_view& text) {
  const std::size_t end = std::min(text.find_first_not_of(kDigits), text.size());
  std::string_view number = text.substr(0, end);
  text.remove_prefix(end);
  number.remove_prefix(std::min(number.find_first_not_of('0'), number.size()));
  return number;
}

Result<std::vector<std::string>> expand(const fs::path& pattern) {
  std::error_code error;
  fs::directory_iterator entries(pattern.parent_path().empty() ? fs::path(".") : pattern.parent_path(), error);
  std::vector<std::string> found;
  const std::string wanted = pattern.filename().string();
  for (; !error && entries != fs::directory_iterator(); entries.increment(error)) {
    if (!matches_wildcard(wanted, entries->path().filename().string())) continue;
    found.push_back((pattern.parent_path() / entries->path().filename()).string());
    if (found.size() > kMaxFiles)
      return fail(ErrorCode::kOutOfRange, fmt::format("more than {} files match {}", kMaxFiles, pattern.string()));
  }
  if (error) return fail(ErrorCode::kNotFound, fmt::format("{}: {}", pattern.string(), error.message()));
  if (found.empty()) return fail(ErrorCode::kNotFound, fmt::format("no file matches {}", pattern.string()));
  std::sort(found.begin(), found.end(), natural_less);
  return found;
}

}  // namespace

Result<std::vector<std::string>> list_files(const std::vector<std::string>& configured, const std::string& directory) {
  std::vector<std::string> files;
  for (const std::string& path : configured) {
    const fs::path whole = fs::path(base::resolve_path(directory, path)).lexically_normal();
    if (whole.filename().string().find_first_of("*?") == std::string::npos) {
      files.push_back(whole.string());
      continue;
    }
    auto expanded = expand(whole);
    if (!expanded) return fail(expanded.error());
    files.insert(files.end(), expanded->begin(), expanded->end());
  }
  return files;
}

bool matches_wildcard(std::string_view pattern, std::string_view name) {
  std::size_t p = 0, n = 0, star = std::string_view::npos, resume = 0;
  while (n < name.size()) {
    if (p < pattern.size() && pattern[p] == '*') {
      star = p++;
      resume = n;
    } else if (p < pattern.size() && (pattern[p] == '?' || pattern[p] == name[n])) {
      ++p, ++n;
    } else if (star != std::string_view::npos) {
      p = star + 1;
      n = ++resume;
    } else {
      return false;
    }
  }
  return pattern.find_first_not_of('*', p) == std::string_view::npos;
}

bool natural_less(std::string_view left, std::string_view right) {
  while (!left.empty() && !right.empty()) {
    if (is_digit(left.front()) && is_digit(right.front())) {
      const std::string_view a = take_number(left), b = take_number(right);
      if (a.size() != b.size()) return a.size() < b.size();
      if (a != b) return a < b;
    } else if (left.front() != right.front()) {
      return left.front() < right.front();
    } else {
      left.remove_prefix(1);
      right.remove_prefix(1);
    }
  }
  return left.size() < right.size();
}

std::string number_in_name(std::string_view path) {
  const std::string stem = fs::path(path).stem().string();
  const std::size_t last = stem.find_last_of(kDigits);
  if (last == std::string::npos) return {};
  const std::size_t before = stem.find_last_not_of(kDigits, last);
  std::string_view digits(stem);
  digits = digits.substr(before == std::string::npos ? 0 : before + 1);
  const std::string_view number = take_number(digits);
  return number.empty() ? "0" : std::string(number);
}

}  // namespace rubicon::networks::log
