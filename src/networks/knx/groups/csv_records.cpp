#include "networks/knx/groups/csv_records.h"

#include <algorithm>
#include <array>

namespace rubicon::networks::knx::groups {

namespace {

constexpr std::size_t kMaxFields = 64;
/// In a row longer than this a quote has no end.
constexpr std::size_t kMaxRecordBytes = 128UL * 1024;
/// After this many quotes without an end the rest of the file is not read. Bounds the time.
constexpr std::size_t kMaxBroken = 1000;

}  // namespace

CsvRecords::CsvRecords(std::string_view text, char delimiter) : text_(text), delimiter_(delimiter) {}

void CsvRecords::skip_break() {
  if (text_[at_] == '\r' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') ++at_;
  ++at_;
  ++line_;
}

void CsvRecords::skip_line() {
  at_ = std::min(text_.find_first_of("\r\n", at_), text_.size());
  if (!at_end()) skip_break();
}

CsvRecords::End CsvRecords::read_quoted(std::string& out) {
  bool many_lines = false;
  for (++at_; !at_end() && at_ - begin_ < kMaxRecordBytes;) {
    if (at_break()) {
      many_lines = true;
      out += '\n';
      skip_break();
    } else if (text_[at_] != '"') {
      out += text_[at_++];
    } else if (at_ + 1 < text_.size() && text_[at_ + 1] == '"') {
      out += '"';
      at_ += 2;
    } else {
      ++at_;
      if (at_end() || at_break()) return End::kRecord;
      if (text_[at_] == delimiter_) return End::kField;
      if (many_lines) return End::kBroken;  // the end quote belongs to another line
      while (!at_end() && !at_break() && text_[at_] != delimiter_) out += text_[at_++];
      return at_end() || at_break() ? End::kRecord : End::kField;
    }
  }
  return End::kBroken;
}

CsvRecords::End CsvRecords::read_field(std::string& out) {
  if (at_end()) return End::kRecord;
  if (text_[at_] == '"') return read_quoted(out);
  while (!at_end() && !at_break() && text_[at_] != delimiter_) out += text_[at_++];
  return at_end() || at_break() ? End::kRecord : End::kField;
}

bool CsvRecords::next(CsvRecord& out) {
  out = {};
  if (at_end()) return false;
  out.line = line_;
  begin_ = at_;
  for (;;) {
    std::string field;
    const auto end = read_field(field);
    if (end == End::kBroken) {
      out.broken = true;
      at_ = begin_;
      line_ = out.line;
      skip_line();
      if (++broken_ > kMaxBroken && !at_end()) {
        gave_up_ = true;
        at_ = text_.size();
      }
      return true;
    }
    if (out.fields.size() < kMaxFields) {
      out.fields.push_back(std::move(field));
    } else {
      out.cut = true;
    }
    if (end == End::kRecord) break;
    ++at_;
  }
  if (!at_end()) skip_break();
  return true;
}

char delimiter_of(std::string_view text) {
  constexpr std::string_view kCandidates = "\t;,";
  std::array<std::size_t, kCandidates.size()> counts{};
  bool quoted = false;
  for (const char c : text.substr(0, 64UL * 1024)) {
    if (c == '"') quoted = !quoted;
    if (quoted) continue;
    const auto which = kCandidates.find(c);
    if (which != kCandidates.npos) ++counts[which];
    const bool any = std::any_of(counts.begin(), counts.end(), [](std::size_t count) { return count != 0; });
    if ((c == '\n' || c == '\r') && any) break;
  }
  const auto best = std::max_element(counts.begin(), counts.end());
  return *best == 0 ? '\0' : kCandidates[static_cast<std::size_t>(best - counts.begin())];
}

}  // namespace rubicon::networks::knx::groups
