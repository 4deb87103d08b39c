#include "transport/transports.h"

namespace rubicon::transport {

namespace {

auto no_files(const std::string& path) {
  return fail(ErrorCode::kUnsupported, path + ": this transport cannot write files");
}

}  // namespace

Result<std::unique_ptr<LocalStream>> Transports::open_local(const std::string& path, LocalCalls) {
  return fail(ErrorCode::kUnsupported, path + ": this transport has no sockets");
}
Result<std::unique_ptr<LocalListener>> Transports::listen_local(const std::string& path, LocalAccept) {
  return fail(ErrorCode::kUnsupported, path + ": this transport has no sockets");
}
Result<std::unique_ptr<AppendFile>> Transports::open_append(const std::string& path) {
  return no_files(path);
}
Result<std::unique_ptr<Worker>> Transports::start_worker(const std::string& name) {
  return fail(ErrorCode::kUnsupported, "there are no threads for " + name);
}
Result<void> Transports::rename_file(const std::string& from, const std::string&) {
  return no_files(from);
}
Result<void> Transports::remove_file(const std::string& path) {
  return no_files(path);
}
Result<std::vector<std::string>> Transports::list_folder(const std::string& path) {
  return no_files(path);
}

}  // namespace rubicon::transport
