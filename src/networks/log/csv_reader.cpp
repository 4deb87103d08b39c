#include "networks/log/csv_reader.h"

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

}  // namespace rubicon::networks::log
