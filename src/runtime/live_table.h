#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/time.h"
#include "tuples/tuple_space.h"

namespace rubicon::runtime {

struct ScreenSize {
  int rows = 24;
  int columns = 80;
};

/// Text of outsiders for a screen: cut to the width in characters, padded with blanks, nothing in it steers a terminal.
std::string fitted(std::string_view text, std::size_t width);

/// The table that `run` shows on a terminal: networks, devices, values with unit, quality and age. A pure function of
/// the tuples a component can see.
class LiveTable {
 public:
  LiveTable(const TupleSpace& space, OwnerId island, std::string name, std::string prefix);

  /// One screen of text, lines separated by newlines, at most size.rows of them (at least 8); the last one is a command
  /// to try. Devices that do not fit are counted in a line of their own.
  std::string render(WallTime now, ScreenSize size) const;

 private:
  struct Row {
    std::string text;
    bool heading = false;
  };
  std::string top_line(WallTime now) const;
  /// What the rows of one screen have in common.
  struct Page {
    WallTime now;
    std::size_t room;  ///< rows, what stands above the devices included
    std::size_t id_width;
  };
  void network_rows(std::vector<Row>& rows) const;
  void all_device_rows(std::vector<Row>& rows, const Page& page) const;
  /// Until the room is full; how many devices fit, with a line left for the count of the others.
  std::size_t device_rows(const std::vector<std::string>& devices, std::vector<Row>& rows, const Page& page) const;
  void point_rows(const std::string& device, std::vector<Row>& rows, const Page& page) const;
  std::string command_to_try() const;
  std::string value(const std::string& key) const;

  const TupleSpace& space_;
  OwnerId island_;
  std::string name_;
  std::string prefix_;
};

}  // namespace rubicon::runtime
