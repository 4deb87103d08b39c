#pragma once

#include <memory>
#include <string>

#include "config/recorder_config.h"
#include "recording/file_head.h"
#include "transport/transports.h"

namespace rubicon::recorder {

/// The file a recorder writes: opens it, cuts off a damaged tail, appends, rotates. A write blocks the loop until the
/// operating system has the block, not until the disk has it.
class RecordingFile {
 public:
  /// `identity` is the head of new files, except its time.
  RecordingFile(transport::Transports& transports, std::string path, recording::FileHead identity,
                config::Rotation rotation);

  bool is_open() const { return file_ != nullptr; }
  const std::string& path() const { return path_; }
  /// In bytes; 0 = it is not open.
  std::uint64_t size() const { return file_ ? file_->size() : 0; }

  struct Opened {
    bool is_new = false;
    std::uint64_t cut = 0;  ///< bytes of a damaged tail
  };
  /// Continues after the last sound block, or begins a file whose first record was seen at `first`. kInvalid if the
  /// file is not a recording of this island.
  Result<Opened> open(WallTime first);
  /// After an error the file is closed, and the incomplete block cut off, at the latest by the next open().
  Result<void> append(ByteView block);

  /// The present snapshot is complete. Its size does not count for the rotation, as one snapshot may be larger than a
  /// file.
  void end_snapshot() { snapshot_size_ = file_ ? file_->size() - opened_size_ : 0; }
  bool rotation_due(WallTime now) const;
  /// Closes the file and renames it by the time of its first record. Closed after an error, too.
  Result<void> rotate();
  /// Removes the oldest of the renamed files beyond those to keep.
  Result<void> remove_old();

 private:
  Result<Opened> resume(WallTime first);
  Result<Opened> begin(WallTime first);

  transport::Transports& transports_;
  std::string path_;
  recording::FileHead identity_;
  config::Rotation rotation_;
  std::unique_ptr<transport::AppendFile> file_;
  WallTime created_{};
  std::uint64_t opened_size_ = 0;  ///< size when it was opened
  std::uint64_t snapshot_size_ = 0;
};

/// `recordings/home.rec` and a time -> `recordings/home-20260131T120000.000000Z.rec`.
std::string rotated_name(const std::string& path, WallTime first);

}  // namespace rubicon::recorder
