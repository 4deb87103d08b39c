#include "networks/knx/dpt/table.h"

#include <algorithm>
#include <array>
#include <vector>

namespace rubicon::networks::knx::dpt {

namespace {

constexpr std::size_t kMains = 286;

/// The rows of one main type.
struct Slot {
  std::span<const Dpt> rows;
  const Dpt* main = nullptr;
};

struct Table {
  std::vector<Dpt> rows;
  std::array<Slot, kMains> slots{};

  Table() {
    for (const auto part : {control_rows(), float_rows(), text_rows(), system_mode_rows(), device_mode_rows(),
                            set_rows(), record_rows()}) {
      rows.insert(rows.end(), part.begin(), part.end());
    }
    for (const auto& main : main_rows()) {
      const auto same = [&](const Dpt& row) { return row.id.main == main.id.main; };
      const auto first = std::find_if(rows.begin(), rows.end(), same);
      const auto end = std::find_if_not(first, rows.end(), same);
      slots[main.id.main] = {{first, end}, &main};
    }
  }
};

const Table& table() {
  static const Table table;
  return table;
}

}  // namespace

std::span<const Dpt> all_dpts() {
  return table().rows;
}

const Dpt* find_dpt(DptId id) {
  if (id.main >= kMains) return nullptr;
  const auto& slot = table().slots[id.main];
  const auto found = std::ranges::lower_bound(slot.rows, id, {}, &Dpt::id);
  if (found != slot.rows.end() && found->id == id) return &*found;
  return slot.main;
}

}  // namespace rubicon::networks::knx::dpt
