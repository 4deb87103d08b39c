#pragma once

#include <memory>
#include <string>

#include "base/log.h"
#include "base/scheduler.h"
#include "frame/figures.h"
#include "frame/process_figures.h"
#include "rubicon/tuple_space.hpp"
#include "transport/asio_scheduler.h"
#include "tuples/link.h"

namespace rubicon::bench {

/// The two components of most measurements. All ids here are of the block that the first member of a realm gets.
inline constexpr OwnerId kFirst{1'070'001}, kSecond{1'070'002};

/// Where the components of one measurement meet; no other components have this tag.
struct Meeting {
  std::uint32_t domain = 0;  ///< of DDS
  std::string tag;
  std::string engine{};  ///< `host`, `dds`; empty = the program has one
  std::string trust{};   ///< folder of certificates; empty = without
};

/// Opens the engine that a program measures. Throws if the engine does not work.
using OpenEngine = std::shared_ptr<tuples::Ecology> (*)(const Meeting& meeting, transport::Loop& loop,
                                                        base::LogSink& log);
inline OpenEngine open_engine = nullptr;  ///< ComponentProgram::open_engine
inline bool awaits_by_name = false;       ///< ComponentProgram::awaits_by_name

/// A component in this process, as a program has one: a loop, an engine, a tuple space.
class Node {
 public:
  /// Ends the process with a message if the engine does not work.
  Node(OwnerId id, const Meeting& meeting);

  tuples::TupleSpace& space() { return *space_; }
  base::Scheduler& scheduler() { return loop_.scheduler(); }
  tuples::Ecology& ecology() { return *ecology_; }

  /// Runs the loop until finish(). Ends the process with a message if that takes longer than `most`.
  void run(base::Duration most);
  void finish() { loop_.stop(); }
  /// Runs the loop for this time.
  void rest(base::Duration time);
  /// Runs until the other component is up.
  void await(OwnerId peer);
  /// Runs until it left or is lost.
  void await_end_of(OwnerId peer);

 private:
  transport::Loop loop_;
  base::NullLogSink log_;
  std::shared_ptr<tuples::Ecology> ecology_;
  std::unique_ptr<tuples::Link> link_;
  std::unique_ptr<tuples::TupleSpace> space_;
};

/// Prints the reason on standard error, and ends the process with code 1.
[[noreturn]] void give_up(const std::string& why);

double seconds_between(SteadyTime from, SteadyTime to);
/// Since 1970, comparable between processes.
double wall_seconds();
/// Processor time of this process so far.
double own_processor_seconds();

/// `text` padded to 64 bytes, the size of all values here.
std::string value_of(std::uint64_t number);
std::uint64_t number_of(std::string_view value);

}  // namespace rubicon::bench
