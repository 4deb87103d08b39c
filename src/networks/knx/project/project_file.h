#pragma once

#include <optional>
#include <string>

#include "networks/knx/project/document.h"
#include "networks/knx/project/project.h"

namespace rubicon::networks::knx::project {

/// The archive of a project, opened: where its parts are and with which password.
class ProjectFile {
 public:
  /// Errors without the name of the file.
  static Result<ProjectFile> open(std::unique_ptr<transport::FileSource> file, const ReadOptions& options);

  const std::string& id() const { return id_; }
  unsigned schema() const { return schema_; }
  bool is_protected() const { return !password_.empty(); }

  /// Reads `project.xml` or `0.xml` into the document.
  Result<void> read_part(std::string_view name, Document& document) const;
  /// Reads an entry of a manufacturer, as `M-0083/Hardware.xml`; kNotFound if there is none.
  Result<void> read_entry(const std::string& name, Document& document) const;

 private:
  explicit ProjectFile(Archive outer) : outer_(std::move(outer)) {}
  Result<void> find_schema();
  Result<void> find_project();
  Result<void> unlock(const ReadOptions& options);
  const Archive::Entry* part(std::string_view name) const;

  Archive outer_;
  std::optional<Archive> inner_;
  std::string id_;
  unsigned schema_ = 0;
  secure::Secret password_;  ///< of the entries of inner_
};

}  // namespace rubicon::networks::knx::project
