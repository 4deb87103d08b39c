#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/output/tuple_text.h"
#include "base/own_file.h"
#include "rubicon/result.hpp"
#include "trust/secret_text.h"
#include "trust/site/site_folder.h"

namespace rubicon::cli::trust {

using rubicon::trust::SecretText;

/// Where a pass phrase comes from, or goes to, besides the terminal.
struct PhraseOptions {
  std::string file;  ///< empty = the terminal
};

/// The first line of the file; else typed on the terminal, which does not show it; else a line of standard input.
/// kInvalid: it is empty.
Result<SecretText> read_phrase(const PhraseOptions& options, const std::string& question);

/// Whether a new phrase can be shown on standard output: a terminal, with text for people. Asked before there is one.
Result<void> may_show_phrase(bool json);
/// Shows it once, on standard output.
void show_phrase(std::string_view phrase);

/// Asks on the terminal; only `y` or `yes`, in upper or lower case, is yes. kInvalid: standard input is not a terminal.
Result<bool> confirmed(const std::string& question);

using rubicon::trust::site::RealmIdentity;

// Each adds one command of `rubicon trust`, or a few that belong together.
void add_may(Cli& cli, CLI::App* parent);
void add_audit(Cli& cli, CLI::App* parent);

/// Who may read a key of this host; `for_people` = --people. kRefused: only root gives one to the group. kNotFound:
/// there is no group.
Result<rubicon::trust::KeyReaders> key_readers(bool for_people);
/// By the clock of this host.
WallTime now();
/// Prints the error; its exit code.
int failed(const Error& error);
/// The same; where root is needed it says so.
int failed_at(const std::filesystem::path& folder, const Error& error);

/// `Rubicon 5f1c`, its fingerprint.
Line as_json(const RealmIdentity& realm);
/// `realm`, `fingerprint`: two lines.
void put(Output& out, const RealmIdentity& realm);

/// The text of a file of at most 256 kB; `-` = standard input.
Result<std::string> read_text(const std::string& file);
/// A new file that only its user may read; under sudo the user who called it. It is opened before its content is made,
/// and removed if nothing was written.
class NewFile {
 public:
  /// kDuplicate: it exists.
  static Result<NewFile> open(const std::string& path);
  NewFile(NewFile&& other) noexcept
      : path_(std::exchange(other.path_, {})), file_(std::move(other.file_)), written_(other.written_) {}
  NewFile& operator=(NewFile&&) = delete;
  ~NewFile();

  const std::string& path() const { return path_; }
  Result<void> write(std::string_view text);

 private:
  NewFile(std::string path, base::OwnFile file) : path_(std::move(path)), file_(std::move(file)) {}

  std::string path_;
  base::OwnFile file_;
  bool written_ = false;
};

}  // namespace rubicon::cli::trust
