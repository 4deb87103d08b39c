#pragma once

#include <string>
#include <string_view>

#include "web/exchange.h"

namespace rubicon::web::files {

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

}  // namespace rubicon::web::files
