#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "web/exchange.h"

namespace rubicon::web::files {

/// The files of the page: those in the program, or those of a folder.
class Page {
 public:
  virtual ~Page() = default;
  /// The answer to a GET; nullopt if there is no such file. The path as it was sent.
  virtual std::optional<Response> find(const Request& request) const = 0;
};

/// A file of the page, as it lies in the program or in a folder.
struct File {
  std::string_view name;   ///< `index.html`, `app-1f2e3d4c.js`
  std::string_view bytes;  ///< valid during the call
  std::string_view hash;   ///< of the bytes; the entity tag
  bool gzip = false;       ///< the bytes are gzip (RFC 1952) of the file
};

/// The answer to a GET: the file, 304 if the client has it (RFC 9110, section 13.1.2), 406 if it takes no gzip.
Response answer(const Request& request, const File& file);

/// The name that a path asks for, without `/`: `index.html` for the root. Empty if no file of a page can have it.
std::string name_in(std::string_view path);

/// `text/html; charset=utf-8`, by the end of the name.
std::string_view media_type(std::string_view name);

/// web/dist as it was when the program was built; written by cmake/embed_page.cmake.
std::vector<File> embedded_files();

/// The page in the program.
class EmbeddedPage final : public Page {
 public:
  explicit EmbeddedPage(std::vector<File> files = embedded_files()) : files_(std::move(files)) {}
  std::optional<Response> find(const Request& request) const override;

 private:
  std::vector<File> files_;
};

/// The files of a folder, read at each request: for those who work on the page.
class FolderPage final : public Page {
 public:
  explicit FolderPage(std::string folder) : folder_(std::move(folder)) {}
  std::optional<Response> find(const Request& request) const override;

 private:
  std::string folder_;
};

}  // namespace rubicon::web::files
