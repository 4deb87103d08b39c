#pragma once

#include <memory>
#include <string>

#include "config/recorder_config.h"
#include "recording/file_head.h"
#include "transport/transports.h"

namespace rubicon::recorder {

/// The file a recorder writes, and those it wrote before: opens, cuts a damaged tail, appends, rotates. Blocks the loop
/// for a write of a block, never until the disk has it.
class RecordingFile {
 public:
  /// `identity` says whose recording it is; its time is set when a file is begun.
  RecordingFile(transport::Transports& transports, std::string path, recording::FileHead identity,
                config::Rotation rotation);

  bool is_open() const { return file_ != nullptr; }
  const std::string& path() const { return path_; }

  struct Opened {
    bool is_new = false;
    std::uint64_t cut = 0;  ///< bytes of a damaged tail
  };
  /// Goes on behind the last sound block, or begins a file whose first record was seen at `first`. kInvalid if the file
  /// is no recording of this island.
  Result<Opened> open(WallTime first);
  /// Closes the file when that fails; what was written of the block is cut off then, now or at the next opening.
  Result<void> append(ByteView block);

  /// What a snapshot takes does not count: else one that is larger than a file would follow the other.
  void snapshot_ends() { weight_of_snapshot_ = file_ ? file_->size() - begin_of_session_ : 0; }
  bool rotation_due(WallTime now) const;
  /// Closes the file and renames it by the time of its first record. After an error it is closed too.
  Result<void> rotate();
  /// Removes the oldest of the renamed files beyond those to keep.
  Result<void> remove_old();

 private:
  Result<Opened> take_up(WallTime first);
  Result<Opened> begin(WallTime first);

  transport::Transports& transports_;
  std::string path_;
  recording::FileHead identity_;
  config::Rotation rotation_;
  std::unique_ptr<transport::AppendFile> file_;
  WallTime created_{};
  std::uint64_t begin_of_session_ = 0;  ///< size when it was opened
  std::uint64_t weight_of_snapshot_ = 0;
};

/// `recordings/home.rec` and a time -> `recordings/home-20260131T120000.000000Z.rec`.
std::string rotated_name(const std::string& path, WallTime first);

}  // namespace rubicon::recorder
