#include "apps/rubicon/live/live_table.h"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "base/clocks.h"

namespace rubicon::cli::live {

void LiveLog::add(Line line) {
  line.text.resize(base::utf8_prefix(std::string_view(line.text).substr(0, kMaxByteCount)));
  if (line.is_complaint) ++complaints_;
  lines_.push_back(std::move(line));
  if (lines_.size() > kKept) lines_.pop_front();
}

namespace {

constexpr int kFewestRows = 8, kFewestColumns = 20;
/// Title and heads above the table; proposal, answer (its first row) and prompt below.
constexpr std::size_t kAbove = 2, kBelow = 3;
constexpr std::size_t kMaxAnswerRows = 4;

/// As fitted(), with an ellipsis where something was cut.
std::string shortened(std::string_view text, std::size_t width) {
  text.remove_suffix(text.size() - (text.find_last_not_of(' ') + 1));
  return width > 0 && base::characters(text) > width ? fitted(text, width - 1) + "…" : fitted(text, width);
}

/// Widths of the columns of points; the others have fixed ones.
struct Columns {
  explicit Columns(std::size_t width)
      : id(std::clamp<std::size_t>(width, 70, 96) - 58),
        value(12 + (width > 96 ? std::min<std::size_t>(width - 96, 28) : 0)) {}
  std::size_t id, value;

  std::string line(std::string_view what, std::string_view shown, std::string_view unit, std::string_view quality,
                   std::string_view heard, std::string_view command) const {
    return fmt::format("    {} {} {} {} {:>6}  {}", shortened(what, id), shortened(shown, value), shortened(unit, 6),
                       shortened(quality, 14), heard, command);
  }
};

constexpr const char* kBold = "\x1b[1m";
constexpr const char* kReverse = "\x1b[7m";
constexpr const char* kDim = "\x1b[2m";

std::string styled(const char* style, const std::string& text) {
  return style + text + "\x1b[0m";
}

constexpr std::string_view kMore = " ! has more";  // the key of the log

/// Rows of a text of several lines, at least one; of what `most` rows do not hold, the end is missing.
std::vector<std::string> wrapped(std::string_view text, std::size_t width, std::size_t most) {
  std::vector<std::string> rows;
  while (true) {
    const auto line = text.substr(0, text.find('\n'));
    const bool is_last = line.size() == text.size(), fits = base::characters(line) <= width;
    if (rows.size() + 1 >= most || (is_last && fits)) {
      rows.push_back(is_last ? shortened(line, width) : fitted(line, width - kMore.size()) + std::string(kMore));
      return rows;
    }
    rows.push_back(fitted(line, width));
    if (fits) text.remove_prefix(line.size() + 1);
    for (std::size_t i = 0; !fits && i < width; ++i) text.remove_prefix(base::first_character(text).size());
  }
}

std::string position(std::size_t top, std::size_t height, std::size_t count) {
  if (count == 0) return "nothing to show";
  return fmt::format("{}-{} of {}", top + 1, std::min(top + height, count), count);
}

}  // namespace

LiveTable::LiveTable(LiveSource source, const LiveLog& log, std::string place)
    : source_(std::move(source)), log_(log), place_(std::move(place)) {}

std::optional<std::string> LiveTable::press(const Stroke& stroke) {
  return view_.press(stroke, scene());
}

LiveView::Scene LiveTable::scene() const {
  const auto at = view_.selected();
  const bool is_point = at < rows_.size() && rows_[at].kind == LiveRow::Kind::kPoint;
  return {rows_, height_, log_.lines().size(), proposal_, is_point ? source_.short_name(rows_[at].key) : ""};
}

std::string LiveTable::whose() const {
  if (islands_.empty()) return fmt::format("Rubicon: no island yet in {}", place_);
  const auto absent = std::count_if(islands_.begin(), islands_.end(), [](const auto& one) { return !one.is_present; });
  if (islands_.size() > 1)
    return fmt::format("Rubicon {} islands{}", islands_.size(), absent > 0 ? fmt::format(", {} absent", absent) : "");
  return fmt::format("Rubicon island {} {}", number(islands_[0].id), absent > 0 ? "is absent" : islands_[0].name);
}

std::string LiveTable::title(WallTime now, std::size_t width) const {
  if (islands_.empty()) return whose();
  const auto count = source_.count();
  const auto& choice = view_.choice();
  const auto name = fmt::format("{}   {}", whose(), count.reachable);
  const auto whole = fmt::format("{} of {} devices reachable", name, count.devices);
  const auto brief = fmt::format("{}/{} reachable", name, count.devices);
  const auto clock = "   " + base::local_seconds_text(now);
  std::string shown;
  if (choice.sort != LiveSort::kNetwork) shown += fmt::format("   sorted: {}", to_string(choice.sort));
  if (log_.complaints() > 0)
    shown += fmt::format("   {} warning{}", log_.complaints(), log_.complaints() == 1 ? "" : "s");
  if (!choice.filter.empty()) shown += fmt::format("   filter: {}", choice.filter);
  // What is shown of the island matters more than the time, and than whole words.
  for (const auto& head : {whole + clock, whole}) {
    if (base::characters(head) + base::characters(shown) <= width) return head + shown;
  }
  return brief + shown;
}

std::string LiveTable::row_text(const LiveRow& row, WallTime now, std::size_t width) const {
  const Columns columns(width);
  const bool grouped = view_.choice().sort == LiveSort::kNetwork;
  const bool folded = view_.choice().folded.contains(row.key) && view_.choice().filter.empty();
  if (row.kind == LiveRow::Kind::kNetwork) {
    const auto network = source_.network(row.key);
    return fmt::format("{} {} {} {}", folded ? "▸" : "▾", fitted(network.name, 20), fitted(network.line, 10),
                       network.reason);
  }
  if (row.kind == LiveRow::Kind::kDevice) {
    const auto device = source_.device(row.key);
    return fmt::format("  {}{}{}{}  {}{}{}", folded ? "▸ " : "", grouped ? device.id : device.network + "." + device.id,
                       device.name.empty() ? "" : "  ", device.name, device.status, device.reason.empty() ? "" : ": ",
                       device.reason);
  }
  const auto point = source_.point(row.key);
  const auto pace = view_.choice().sort == LiveSort::kBusiest ? fmt::format("{:.1f}", point.per_second)
                                                              : base::age_text(point.heard, now);
  const auto name = point.name.empty() ? point.id : fmt::format("{}  {}", point.id, point.name);
  return columns.line(name, point.value, point.unit, point.quality, pace, point.command);
}

void LiveTable::put_table(std::vector<std::string>& lines, WallTime now, std::size_t width) const {
  for (std::size_t i = 0; i < height_; ++i) {
    const auto at = view_.top() + i;
    if (at >= rows_.size()) {
      lines.push_back(fitted("", width));
      continue;
    }
    const auto text = shortened(row_text(rows_[at], now, width), width);
    const bool selected = at == view_.selected() && view_.prompt() == LiveView::Prompt::kNone;
    const bool head = rows_[at].kind == LiveRow::Kind::kNetwork;
    lines.push_back(selected ? styled(kReverse, text) : head ? styled(kBold, text) : text);
  }
}

void LiveTable::put_log(std::vector<std::string>& lines, std::size_t height, std::size_t width) const {
  const auto& all = log_.lines();
  const auto most = all.size() - std::min(all.size(), height);
  const auto top = most - std::min(most, view_.log_back());
  for (std::size_t i = 0; i < height; ++i) {
    if (top + i >= all.size()) {
      lines.push_back(fitted("", width));
      continue;
    }
    const auto& line = all[top + i];
    const auto text = shortened(fmt::format("{}  {}", base::local_seconds_text(line.time), line.text), width);
    lines.push_back(line.is_complaint ? styled(kBold, text) : text);
  }
}

void LiveTable::put_help(std::vector<std::string>& lines, std::size_t height, std::size_t width) {
  const auto& help = LiveView::help();
  for (std::size_t i = 0; i < height; ++i) lines.push_back(shortened(i < help.size() ? help[i] : "", width));
}

void LiveTable::put_body(std::vector<std::string>& lines, WallTime now, std::size_t room, std::size_t width) {
  const auto log = view_.log();
  const bool below = log == LiveView::Log::kBelow;
  const auto log_height = below ? room / 3 : log == LiveView::Log::kWhole ? room : 0;
  height_ = below ? room - log_height - 1 : room;
  rows_ = live_rows(source_, view_.choice());
  view_.follow(scene());
  if (view_.help_shown()) return put_help(lines, room, width);
  if (log == LiveView::Log::kWhole) return put_log(lines, room, width);
  put_table(lines, now, width);
  if (!below) return;
  lines.push_back(styled(kBold, fitted("LOG", width)));
  put_log(lines, log_height, width);
}

std::string LiveTable::prompt(std::size_t width, std::size_t& cursor) const {
  const bool filter = view_.prompt() == LiveView::Prompt::kFilter;
  if (view_.prompt() == LiveView::Prompt::kNone) {
    cursor = 3;
    const auto where =
        view_.log() == LiveView::Log::kWhole ? counted_log() : position(view_.top(), height_, rows_.size());
    return "> " + styled(kDim, shortened(fmt::format("  {}   / filter   < > sort   Enter fold   ! log   ? help", where),
                                         width - 2));
  }
  // Of a long line the end is shown: there one types.
  const auto clean = fitted(view_.typed(), view_.typed().size());
  std::string shown = clean.substr(0, clean.find_last_not_of(' ') + 1);
  const auto blanks = view_.typed().size() - (view_.typed().find_last_not_of(' ') + 1);
  shown += std::string(blanks, ' ');
  const auto room = width - 3;
  std::size_t characters = base::characters(shown);
  while (characters > room) {
    shown.erase(0, 1);
    while (!shown.empty() && (static_cast<unsigned char>(shown.front()) & 0xc0U) == 0x80) shown.erase(0, 1);
    --characters;
  }
  cursor = 3 + characters;
  return (filter ? "/ " : "> ") + fitted(shown, width - 2);
}

std::string LiveTable::counted_log() const {
  const auto count = log_.lines().size();
  const auto most = count - std::min(count, height_);
  return "log " + position(most - std::min(most, view_.log_back()), height_, count);
}

LiveFrame LiveTable::frame(WallTime now, ScreenSize size, const std::string& answer) {
  const auto rows = static_cast<std::size_t>(std::max(size.rows, kFewestRows));
  const auto width = static_cast<std::size_t>(std::max(size.columns, kFewestColumns));
  const auto room_for_both = rows - kAbove - kBelow;
  const auto answer_rows = wrapped(answer, width, std::min(kMaxAnswerRows, 1 + room_for_both / 3));
  const auto room = room_for_both + 1 - answer_rows.size();
  LiveFrame frame;
  std::vector<std::string> body;
  islands_ = source_.look();
  proposal_ = source_.command_to_try();
  put_body(body, now, room, width);
  frame.lines.push_back(styled(kBold, shortened(title(now, width), width)));
  const auto* pace = view_.choice().sort == LiveSort::kBusiest ? "/S" : "HEARD";
  const auto heads = Columns(width).line("", "VALUE", "UNIT", "QUALITY", pace, "COMMAND");
  frame.lines.push_back(styled(kBold, shortened("DEVICE" + heads.substr(6), width)));
  for (auto& line : body) frame.lines.push_back(std::move(line));
  frame.lines.push_back(shortened(" try: " + proposal_, width));
  frame.lines.insert(frame.lines.end(), answer_rows.begin(), answer_rows.end());
  frame.lines.push_back(prompt(width, frame.cursor_column));
  // A screen too small for that shows the end.
  const auto shown = static_cast<std::size_t>(std::max(size.rows, 1));
  if (frame.lines.size() > shown)
    frame.lines.erase(frame.lines.begin(), frame.lines.end() - static_cast<std::ptrdiff_t>(shown));
  return frame;
}

}  // namespace rubicon::cli::live
