#include "apps/rubicon-proxy/state_tool.h"

#include <fcntl.h>
#include <fmt/format.h>

#include <filesystem>
#include <fstream>
#include <iostream>
#include <map>

#include "apps/rubicon-proxy/daemon.h"
#include "base/clocks.h"
#include "base/own_file.h"
#include "base/text.h"
#include "rubicon/key.hpp"
#include "state/state_export.h"
#include "state/state_store.h"

namespace rubicon::daemon {

namespace {

using base::printable;
using state::KnownDevice;
using state::StateStore;

constexpr std::size_t kMaxImportErrors = 20;

int failed(const Error& error) {
  fmt::print(stderr, "{}\n", error.text);
  return kExitFailed;
}

std::string time_text(WallTime time) {
  // Years of four digits; a damaged row may say anything.
  constexpr WallTime kLast{std::chrono::seconds(253'402'300'799)};
  if (time <= WallTime{} || time > kLast) return "never";
  return base::utc_text(time, "%Y-%m-%d %H:%M:%S");
}

Result<std::unique_ptr<StateStore>> open_for_reading(const std::string& file) {
  return StateStore::open_existing(file, StateStore::Use::kRead);
}

Result<std::unique_ptr<StateStore>> open_for_writing(const std::string& file) {
  auto store = StateStore::open_existing(file, StateStore::Use::kWrite);
  if (store && (*store)->stats().read_only) {
    return fail(ErrorCode::kRefused, fmt::format("state file {}: may not be written", file));
  }
  return store;
}

void warn_of_damage(const StateStore& store) {
  const auto damaged = store.stats().damaged;
  if (damaged > 0) fmt::print(stderr, "{} devices or values could not be read and are left out\n", damaged);
}

Result<std::uint64_t> export_to(const StateStore& store, std::ostream& out) {
  std::uint64_t devices = 0;
  out << state::export_head(store.island()) << '\n';
  const auto read = store.each("", [&](StateStore::Row, KnownDevice&& device) {
    out << state::export_line(device) << '\n';
    ++devices;
  });
  if (!read) return fail(read.error());
  out << state::export_end(devices) << '\n' << std::flush;
  if (!out) return fail(ErrorCode::kIo, "writing the export failed");
  return devices;
}

/// A line without its end, of at most kMaxExportLine bytes and one more.
bool read_line(std::istream& in, std::string& line) {
  line.clear();
  for (int c = in.get(); c != std::char_traits<char>::eof(); c = in.get()) {
    if (c == '\n') {
      if (line.ends_with('\r')) line.pop_back();
      return true;
    }
    line.push_back(static_cast<char>(c));
    if (line.size() > state::kMaxExportLine) return true;
  }
  return !line.empty();
}

/// An import on its way: one transaction, in which nothing survives the first error.
class Import {
 public:
  Import(const std::string& file, bool force) : file_(file), force_(force) {}

  Result<void> run(std::istream& in) {
    std::string line;
    while (errors_.size() < kMaxImportErrors && read_line(in, line)) {
      auto device = reader_.line(line);
      if (!device) {
        errors_.push_back(device.error().text);
        if (!reader_.island() || line.size() > state::kMaxExportLine) break;
      } else if (auto done = *device ? put(**device) : open(); !done) {
        return done;
      }
      ++lines_;
    }
    if (auto whole = reader_.end(); errors_.empty() && !whole) errors_.push_back(whole.error().text);
    if (errors_.empty()) return store_->commit(true);
    for (const auto& error : errors_) fmt::print(stderr, "{}\n", error);
    return fail(ErrorCode::kInvalid, fmt::format("state file {}: nothing was imported", file_));
  }

  /// After an error: removes the file if this import made it.
  void undo() {
    store_.reset();
    if (!made_) return;
    std::error_code ignored;
    for (const auto* suffix : {"", "-lock"}) std::filesystem::remove(file_ + suffix, ignored);
  }

  std::uint64_t devices() const { return first_line_.size(); }
  const StateStore& store() const { return *store_; }

 private:
  /// Called when the first line named the island of the export.
  Result<void> open() {
    if (store_) return {};
    const auto island = *reader_.island();
    const bool there = std::filesystem::exists(file_);
    auto store = there ? open_for_writing(file_) : StateStore::open(file_, island);
    if (!store) return fail(store.error());
    made_ = !there;
    store_ = std::move(*store);
    if (store_->island() == island || force_) return store_->begin();
    return fail(ErrorCode::kRefused,
                fmt::format("state file {} is of island {}, the export is of island {} (--force imports it anyway)",
                            file_, number(store_->island()), number(island)));
  }

  Result<void> put(KnownDevice& device) {
    const auto line = lines_ + 1;
    const auto [first, fresh] = first_line_.emplace(std::pair(device.network, device.address), line);
    if (!fresh) {
      errors_.push_back(fmt::format("line {}: device {}/{} stands in line {} already", line, device.network,
                                    device.address, first->second));
      return {};
    }
    const auto values = std::move(device.values);
    device.values.clear();
    const auto row = store_->save(device);
    if (!row) return refuse(line, row.error());
    if (auto done = store_->save_values(*row, values); !done) return refuse(line, done.error());
    const auto heard_later = [&](const state::StoredValue& value) { return value.heard > device.last_heard; };
    if (std::none_of(values.begin(), values.end(), heard_later)) return {};
    const auto as_exported = store_->save(device);
    return as_exported ? Result<void>() : fail(as_exported.error());
  }

  Result<void> refuse(std::uint64_t line, const Error& error) {
    if (error.code != ErrorCode::kOutOfRange) return fail(error);
    errors_.push_back(fmt::format("line {}: {}", line, error.text));
    return {};
  }

  const std::string& file_;
  bool force_;
  bool made_ = false;
  state::ExportReader reader_;
  std::unique_ptr<StateStore> store_;
  std::uint64_t lines_ = 0;
  std::map<std::pair<std::string, std::string>, std::uint64_t> first_line_;
  std::vector<std::string> errors_;
};

/// Whether `name` names the device: NETWORK/ADDRESS as they are, or NETWORK.ID as they stand in keys.
bool is_called(const std::string& name, const KnownDevice& device) {
  if (name == device.network + "/" + device.address) return true;
  if (device.id.empty()) return false;
  const auto key = model::to_key_part(device.network) + "." + device.id;
  return name == key || name.ends_with("." + key);  // the island's prefix may stand before it
}

Result<KnownDevice> find_device(const StateStore& store, const std::string& name) {
  std::vector<KnownDevice> found;
  const auto read = store.each("", [&](StateStore::Row, KnownDevice&& device) {
    if (is_called(name, device)) found.push_back(std::move(device));
  });
  if (!read) return fail(read.error());
  if (found.size() == 1) return std::move(found.front());
  if (found.empty()) return fail(ErrorCode::kNotFound, fmt::format("{}: no such device is remembered", name));
  return fail(ErrorCode::kDuplicate, fmt::format("{}: names several devices, expected NETWORK/ADDRESS", name));
}

/// A name without address or id means a network.
bool is_network(const std::string& name) {
  return name.find_first_of("/.") == name.npos;
}

Result<void> forget_all(StateStore& store, const std::vector<std::string>& names_given) {
  if (auto begun = store.begin(); !begun) return begun;
  for (const auto& name : names_given) {
    if (is_network(name)) {
      if (auto done = store.forget_memory(name); !done) return done;
      continue;
    }
    const auto slash = name.find('/');
    // Also a device whose row cannot be read.
    if (slash != name.npos && store.forget(name.substr(0, slash), name.substr(slash + 1))) continue;
    const auto device = find_device(store, name);
    if (!device) return fail(device.error());
    if (auto done = store.forget(device->network, device->address); !done) return done;
  }
  return store.commit(true);
}

Result<void> show_memories(const StateStore& store) {
  const auto all = store.memories();
  if (!all) return fail(all.error());
  if (!all->empty()) fmt::print("\n{:<32} {:>6} {:>9}\n", "NETWORK", "VALUES", "BYTES");
  for (const auto& one : *all) fmt::print("{:<32} {:>6} {:>9}\n", printable(one.network), one.values, one.bytes);
  return {};
}

}  // namespace

int show_state(const std::string& file) {
  const auto store = open_for_reading(file);
  if (!store) return failed(store.error());
  const auto stats = (*store)->stats();
  fmt::print("{}: island {}, {} devices, {} values, {} bytes\n", file, number((*store)->island()), stats.devices,
             stats.values, stats.bytes);
  fmt::print("{:<32} {:<20} {:<9} {:<19} {:>6}\n", "DEVICE", "ID", "DECISION", "LAST HEARD (UTC)", "VALUES");
  const auto read = (*store)->each("", [](StateStore::Row, KnownDevice&& device) {
    const auto name = printable(device.network + "/" + device.address);
    fmt::print("{:<32} {:<20} {:<9} {:<19} {:>6}\n", name, printable(device.id), to_string(device.decision),
               time_text(device.last_heard), device.values.size());
  });
  if (!read) return failed(read.error());
  if (auto shown = show_memories(**store); !shown) return failed(shown.error());
  warn_of_damage(**store);
  return kExitOk;
}

int export_state(const std::string& file, const std::string& out) {
  const auto store = open_for_reading(file);
  if (!store) return failed(store.error());
  std::ofstream target;
  if (!out.empty()) {
    if (auto made = OwnFile::open(out, O_WRONLY | O_TRUNC); !made) return failed(made.error());
    target.open(out, std::ios::binary | std::ios::trunc);
    if (!target) return failed({ErrorCode::kIo, fmt::format("{}: cannot be written", out)});
  }
  const auto exported = export_to(**store, out.empty() ? std::cout : target);
  if (!exported) return failed(exported.error());
  warn_of_damage(**store);
  return kExitOk;
}

int import_state(const std::string& file, const std::string& from, bool force) {
  std::ifstream source;
  if (from != "-") {
    source.open(from, std::ios::binary);
    if (!source) return failed({ErrorCode::kIo, fmt::format("{}: cannot be read", from)});
  }
  Import import(file, force);
  if (auto done = import.run(from == "-" ? std::cin : source); !done) {
    import.undo();
    return failed(done.error());
  }
  fmt::print("{}: {} devices imported, {} remembered now\n", file, import.devices(), import.store().stats().devices);
  return kExitOk;
}

int forget_state(const std::string& file, const std::vector<std::string>& devices) {
  const auto store = open_for_writing(file);
  if (!store) return failed(store.error());
  if (auto done = forget_all(**store, devices); !done) return failed(done.error());
  for (const auto& device : devices) fmt::print("{}: forgotten\n", device);
  return kExitOk;
}

}  // namespace rubicon::daemon
