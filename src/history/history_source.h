#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "history/series.h"
#include "rubicon/key.hpp"
#include "rubicon/result.hpp"
#include "rubicon/tuple_space.hpp"

namespace rubicon::history {

/// What a history did since it began.
struct HistoryCounters {
  std::uint64_t points = 0;    ///< written
  std::uint64_t dropped = 0;   ///< that could not be written
  std::uint64_t failures = 0;  ///< to open, write and read the file
  std::uint64_t bytes = 0;     ///< present size of the file
  bool recording = false;      ///< the file is open, and all is written
};

/// The past of tuples, for programs that ask: in their own words, so that long answers are not written on the loop.
class HistorySource {
 public:
  /// Puts an answer into words. It runs on another thread than its maker's: it uses nothing of the loop.
  using AnswerText = std::function<std::string(const Answer&)>;
  using SeriesText = std::function<std::string(const std::vector<SeriesEntry>&)>;
  /// Called in a later turn; destroying the handle cancels it.
  using TextCall = std::function<void(Result<std::string>)>;

  virtual ~HistorySource() = default;

  /// The past of some series. Callers have their turns one after the other, whoever of them has more questions.
  /// kInvalid: a question beyond its limits; kExpired: its answer would take too long; kBusy: too many questions wait;
  /// kIo or kInvalid: the file cannot be read.
  [[nodiscard]] virtual Handle ask(const std::string& caller, Question question, AnswerText text, TextCall call) = 0;
  /// The series whose tuples match.
  [[nodiscard]] virtual Handle series(const std::string& caller, Pattern pattern, SeriesRange range, SeriesText text,
                                      TextCall call) = 0;
  virtual HistoryCounters counters() const = 0;
};

/// `number`, `words`, `text`.
std::string_view to_string(SeriesKind kind);

/// The JSON of docs/history.md#answers, on one line. Times are seconds since 1970.
std::string to_json(const Answer& answer);
/// One line for each bucket, and for each text; begins with the names of the columns. RFC 4180 with LF.
std::string to_csv(const Answer& answer);
/// `{"series":[{"key","kind","unit","words"?,"first","last"}]}`, on one line.
std::string to_json(const std::vector<SeriesEntry>& series);

/// `6541:proxy.wsn-1.7.sensor.light-1.value`.
std::string to_string(const SeriesName& name);
/// kInvalid for what has no owner or is not a key.
Result<SeriesName> parse_series(std::string_view text);

/// Column names of append_point_line(), with their line end.
inline constexpr std::string_view kPointHeader = "time,owner,key,value\n";
/// One value; empty = a gap begins. RFC 4180 with LF.
void append_point_line(const SeriesName& name, WallTime time, std::string_view value, std::string& out);
/// The value as in its tuple; empty for a gap.
std::string value_text(const SeriesEntry& series, const Point& point);

}  // namespace rubicon::history
