#include "console/live_view.h"

#include <algorithm>
#include <utility>

#include "console/shell.h"

namespace rubicon::console {

namespace {

using Key = Stroke::Key;

/// Removes the last character, which may be of several bytes.
void erase_character(std::string& text) {
  while (!text.empty()) {
    const auto last = static_cast<unsigned char>(text.back());
    text.pop_back();
    if ((last & 0xc0U) != 0x80) return;
  }
}

void erase_word(std::string& text) {
  while (!text.empty() && text.back() == ' ') text.pop_back();
  while (!text.empty() && text.back() != ' ') text.pop_back();
}

std::size_t moved(std::size_t at, Key key, std::size_t page, std::size_t count) {
  switch (key) {
    case Key::kUp: return at - std::min<std::size_t>(at, 1);
    case Key::kDown: return at + 1;
    case Key::kPageUp: return at - std::min(at, page);
    case Key::kPageDown: return at + page;
    case Key::kHome: return 0;
    default: return count;
  }
}

}  // namespace

const std::vector<std::string>& LiveView::help() {
  static const std::vector<std::string> lines{
      "The live table",
      "  Up, Down, PgUp, PgDn, Home, End   move",
      "  /                                 filter: words that must all stand in",
      "                                    a row or above it (kitchen stale)",
      "  < >                               sort: network, name, latest, trouble",
      "  Enter                             fold, unfold; on an actuator, begin to set",
      "  - +                               fold and unfold all",
      "  !                                 the log: below the table, alone, hidden",
      "  ?                                 this page",
      "  Esc                               leaves a line, a page, a filter",
      "Every letter begins a command line, and so does a colon:",
      "  set KEY VALUE, devices, inbox, reload, quit, help, ... (docs/shell.md)",
      "  Tab                               types the line that is proposed",
      "  Ctrl-P, Ctrl-N                    an earlier line, a later one",
      "  Ctrl-W, Ctrl-U                    erase a word, the line",
      "Ctrl-C ends the island. While the table is shown all sensors are sampled.",
  };
  return lines;
}

std::optional<std::string> LiveView::press(const Stroke& stroke, const Scene& scene) {
  switch (stroke.key) {
    case Key::kText:
      if (prompt_ == Prompt::kNone && stroke.text.size() == 1 &&
          std::string_view("/<>-+!?:").find(stroke.text[0]) != std::string_view::npos) {
        look(stroke.text[0], scene);
      } else {
        type(stroke.text);
      }
      break;
    case Key::kEnter: return enter(scene);
    case Key::kEscape: escape(); break;
    case Key::kTab:
      if (prompt_ == Prompt::kNone) type(scene.proposal);
      break;
    case Key::kBackspace:
    case Key::kEraseWord:
    case Key::kEraseLine: erase(stroke.key); break;
    case Key::kEarlier: recall(1); break;
    case Key::kLater: recall(-1); break;
    case Key::kRedraw: break;
    default: move(stroke.key, scene); break;
  }
  return std::nullopt;
}

void LiveView::type(const std::string& text) {
  if (prompt_ == Prompt::kNone && text == " ") return;
  if (prompt_ == Prompt::kNone) prompt_ = Prompt::kCommand;
  if (typed_.size() + text.size() <= Shell::kMaxLine) typed_ += text;
  if (prompt_ == Prompt::kFilter) choice_.filter = typed_;
}

std::optional<std::string> LiveView::enter(const Scene& scene) {
  const auto prompt = std::exchange(prompt_, Prompt::kNone);
  auto line = std::exchange(typed_, {});
  recalled_ = 0;
  if (prompt == Prompt::kFilter) return std::nullopt;
  if (prompt == Prompt::kNone) {
    if (help_ || log_ == Log::kWhole) return std::nullopt;
    open_or_fold(scene);
    return std::nullopt;
  }
  if (line.find_first_not_of(' ') == line.npos) return std::nullopt;
  if (earlier_.empty() || earlier_.back() != line) earlier_.push_back(line);
  if (earlier_.size() > kMostEarlier) earlier_.pop_front();
  return line;
}

void LiveView::escape() {
  if (prompt_ != Prompt::kNone) {
    if (prompt_ == Prompt::kFilter) choice_.filter.clear();
    prompt_ = Prompt::kNone;
    typed_.clear();
    recalled_ = 0;
  } else if (help_) {
    help_ = false;
  } else if (log_ != Log::kHidden) {
    log_ = Log::kHidden;
  } else {
    choice_.filter.clear();
  }
}

void LiveView::erase(Key key) {
  if (prompt_ == Prompt::kNone) return;
  if (typed_.empty() && key == Key::kBackspace) return escape();
  if (key == Key::kBackspace) erase_character(typed_);
  if (key == Key::kEraseWord) erase_word(typed_);
  if (key == Key::kEraseLine) typed_.clear();
  if (prompt_ == Prompt::kFilter) choice_.filter = typed_;
}

void LiveView::look(char key, const Scene& scene) {
  switch (key) {
    case '/':
      prompt_ = Prompt::kFilter;
      typed_ = choice_.filter;
      help_ = false;
      break;
    case ':': prompt_ = Prompt::kCommand; break;
    case '<': sort(-1); break;
    case '>': sort(1); break;
    case '-': fold_all(true, scene); break;
    case '+': fold_all(false, scene); break;
    case '!':
      log_ = log_ == Log::kHidden ? Log::kBelow : log_ == Log::kBelow ? Log::kWhole : Log::kHidden;
      log_back_ = 0;
      break;
    default: help_ = !help_; break;
  }
}

void LiveView::sort(int step) {
  constexpr int kSorts = 4;
  choice_.sort = static_cast<LiveSort>((static_cast<int>(choice_.sort) + kSorts + step) % kSorts);
}

void LiveView::open_or_fold(const Scene& scene) {
  if (selected_ >= scene.rows.size()) return;
  const auto& row = scene.rows[selected_];
  if (row.kind != LiveRow::Kind::kPoint) {
    if (choice_.folded.erase(row.key) == 0) choice_.folded.insert(row.key);
  } else if (row.key.find(".actuator.") != row.key.npos) {
    type("set " + row.key + ".command ");
  }
}

void LiveView::fold_all(bool fold, const Scene& scene) {
  choice_.folded.clear();
  const auto kind = choice_.sort == LiveSort::kNetwork ? LiveRow::Kind::kNetwork : LiveRow::Kind::kDevice;
  for (const auto& row : scene.rows) {
    if (fold && row.kind == kind) choice_.folded.insert(row.key);
  }
}

void LiveView::recall(int step) {
  if (prompt_ == Prompt::kFilter) return;
  const auto most = static_cast<int>(earlier_.size());
  recalled_ = static_cast<std::size_t>(std::clamp(static_cast<int>(recalled_) + step, 0, most));
  typed_ = recalled_ == 0 ? std::string() : earlier_[earlier_.size() - recalled_];
  prompt_ = typed_.empty() ? Prompt::kNone : Prompt::kCommand;
}

void LiveView::move(Key key, const Scene& scene) {
  if (log_ == Log::kWhole) return move_log(key, scene);
  selected_ = moved(selected_, key, std::max<std::size_t>(scene.height, 1), scene.rows.size());
  selected_ = std::min(selected_, scene.rows.empty() ? 0 : scene.rows.size() - 1);
  selected_key_ = selected_ < scene.rows.size() ? scene.rows[selected_].key : std::string();
  if (selected_ == 0) selected_key_.clear();  // at the top one stays at the top
  follow(scene);
}

void LiveView::move_log(Key key, const Scene& scene) {
  const auto most = scene.log_lines - std::min(scene.log_lines, scene.height);
  const auto top = most - std::min(most, log_back_);
  log_back_ = most - std::min(moved(top, key, std::max<std::size_t>(scene.height, 1), most), most);
}

void LiveView::follow(const Scene& scene) {
  const auto& rows = scene.rows;
  if (!selected_key_.empty()) {
    const auto found =
        std::find_if(rows.begin(), rows.end(), [this](const LiveRow& row) { return row.key == selected_key_; });
    if (found != rows.end()) selected_ = static_cast<std::size_t>(found - rows.begin());
  }
  selected_ = std::min(selected_, rows.empty() ? 0 : rows.size() - 1);
  const auto height = std::max<std::size_t>(scene.height, 1);
  top_ = std::min(top_, rows.size() - std::min(rows.size(), height));
  top_ = std::min(top_, selected_);
  if (selected_ >= top_ + height) top_ = selected_ - height + 1;
}

}  // namespace rubicon::console
