#include "networks/log/file_chain.h"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

#include "base/text.h"

namespace rubicon::networks::log {

namespace {

constexpr std::string_view kBlanks = " \t\r";
constexpr std::string_view kByteOrderMark = "\xef\xbb\xbf";

bool is_blank(char c) {
  return kBlanks.find(c) != std::string_view::npos;
}

/// Where the cell that begins at `from` ends: at a separator outside quotes, or at the end.
std::size_t cell_end(std::string_view line, std::size_t from, std::string_view separators) {
  std::size_t first = from;
  while (first < line.size() && is_blank(line[first]) && separators.find(line[first]) == std::string_view::npos)
    ++first;
  std::size_t at = first;
  if (at < line.size() && line[at] == '"') {
    const std::size_t closing = line.find('"', at + 1);
    if (closing != std::string_view::npos) at = closing + 1;
  }
  const std::size_t end = line.find_first_of(separators, at);
  return end == std::string_view::npos ? line.size() : end;
}

std::string_view unquoted(std::string_view cell) {
  cell = base::trimmed(cell);
  if (cell.size() >= 2 && cell.front() == '"' && cell.back() == '"') cell = cell.substr(1, cell.size() - 2);
  return cell;
}

}  // namespace

void split_cells(std::string_view line, std::string_view separators, std::vector<std::string_view>& cells) {
  cells.clear();
  std::string visible;
  for (const char c : separators) {
    if (!is_blank(c)) visible += c;
  }
  const bool by_blanks = visible.empty() || line.find_first_of(visible) == std::string_view::npos;
  if (by_blanks && visible.size() != separators.size()) {
    line = base::trimmed(line);
    for (std::size_t at = 0; at < line.size();) {
      const std::size_t end = cell_end(line, at, kBlanks);
      cells.push_back(unquoted(line.substr(at, end - at)));
      at = line.find_first_not_of(kBlanks, end);
      if (at == std::string_view::npos) break;
    }
    return;
  }
  for (std::size_t at = 0;;) {
    const std::size_t end = cell_end(line, at, visible);
    cells.push_back(unquoted(line.substr(at, end - at)));
    if (end == line.size()) return;
    at = end + 1;
  }
}

void LineReader::drop_front(std::size_t count) {
  buffer_.erase(0, count);
  base_ += count;
  position_ = 0;
}

void LineReader::feed(ByteView bytes) {
  drop_front(position_);
  buffer_.append(base::as_text(bytes));
}

TextLine LineReader::take_line(std::size_t end, std::size_t line_end) {
  TextLine line;
  line.number = ++number_;
  line.offset = in_long_line_ ? long_offset_ : base_ + position_;
  line.bytes = base_ + end + line_end - line.offset;
  line.too_long = in_long_line_ || end - position_ > kMaxLine;
  if (!line.too_long) {
    std::string_view text = std::string_view(buffer_).substr(position_, end - position_);
    if (number_ == 1 && text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
    if (text.ends_with('\r')) text.remove_suffix(1);
    line.text = text;
  }
  in_long_line_ = false;
  position_ = end + line_end;
  return line;
}

std::optional<TextLine> LineReader::next() {
  const std::size_t end = buffer_.find('\n', position_);
  if (end != std::string::npos) return take_line(end, 1);
  if (!ended_) {
    if (buffer_.size() - position_ > kMaxLine) {
      if (!in_long_line_) long_offset_ = base_ + position_;
      in_long_line_ = true;
      drop_front(buffer_.size());
    }
    return std::nullopt;
  }
  if (position_ == buffer_.size() && !in_long_line_) return std::nullopt;
  return take_line(buffer_.size(), 0);
}

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

namespace {

constexpr std::size_t kPiece = 64UL * 1024;
constexpr std::size_t kMaxTable = 16 * kPiece;

/// The second cell of the line whose first cell is `key`.
std::optional<std::string> label_in(const TextLine& line, const std::string& key) {
  std::vector<std::string_view> cells;
  split_cells(line.text, ",;\t", cells);
  if (cells.size() < 2 || cells[0] != key) return std::nullopt;
  return std::string(cells[1]);
}

}  // namespace

FileChain::FileChain(transport::Transports& transports, Recording& recording)
    : transports_(transports), recording_(recording), piece_(kPiece) {}

Result<void> FileChain::open(std::vector<std::string> files) {
  files_ = std::move(files);
  if (index_ >= files_.size()) index_ = 0;
  return open_current();
}

Result<void> FileChain::rewind() {
  index_ = 0;
  recording_.restart();
  return open_current();
}

Result<void> FileChain::open_current() {
  auto file = transports_.open_file(path());
  if (!file) return fail(file.error());
  std::vector<std::string> labels;
  for (const std::string& table : recording_.label_tables()) {
    auto label = label_of(table, number_in_name(path()));
    if (!label) return fail(label.error());
    labels.push_back(std::move(*label));
  }
  file_ = std::move(*file);
  ended_ = false;
  recording_.begin(path(), std::move(labels));
  return {};
}

Result<std::string> FileChain::label_of(const std::string& table, const std::string& key) {
  auto file = transports_.open_file(table);
  if (!file) return fail(file.error());
  LineReader lines;
  std::size_t read = 0;
  for (bool more = true; more && read < kMaxTable;) {
    const auto count = (*file)->read(piece_);
    if (!count) return fail(count.error());
    more = *count > 0;
    read += *count;
    if (more)
      lines.feed(ByteView(piece_).first(*count));
    else
      lines.end();
    while (const auto line = lines.next()) {
      if (auto label = label_in(*line, key)) return std::move(*label);
    }
  }
  return std::string();
}

Result<FileChain::Found> FileChain::next(Step& step) {
  if (auto found = recording_.next()) {
    step = std::move(*found);
    return Found::kStep;
  }
  if (auto failure = recording_.failure()) return fail(failure->code, fmt::format("{}: {}", path(), failure->text));
  if (recording_.has_more()) return Found::kNothingYet;
  if (!ended_) {
    const auto count = file_->read(piece_);
    if (!count) return fail(count.error());
    ended_ = *count == 0;
    if (ended_)
      recording_.end();
    else
      recording_.feed(ByteView(piece_).first(*count));
    return Found::kNothingYet;
  }
  if (index_ + 1 == files_.size()) return Found::kEnd;
  ++index_;
  if (auto opened = open_current(); !opened) return fail(opened.error());
  return Found::kNextFile;
}

}  // namespace rubicon::networks::log
