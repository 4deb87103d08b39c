#include "transport/transports.h"

#include <fmt/format.h>
#include <pthread.h>
#include <sys/resource.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <condition_variable>
#include <deque>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

#include "base/assert.h"
#include "transport/sockets.h"

namespace rubicon::transport {

namespace {

constexpr int kNice = 5;  // the loop comes first

class ThreadWorker final : public Worker {
 public:
  explicit ThreadWorker(const std::string& name) : thread_([this, name] { run_jobs(name); }) {}

  ~ThreadWorker() override {
    {
      const std::lock_guard lock(mutex_);
      ending_ = true;
    }
    changed_.notify_one();
    thread_.join();
  }

  void run(Job job) override {
    {
      const std::lock_guard lock(mutex_);
      jobs_.push_back(std::move(job));
    }
    changed_.notify_one();
  }

 private:
  void run_jobs(const std::string& name) {
    ::pthread_setname_np(::pthread_self(), name.substr(0, 15).c_str());
    // On Linux a priority is that of a thread.
    ::setpriority(PRIO_PROCESS, static_cast<id_t>(::syscall(SYS_gettid)), kNice);
    while (auto job = next()) job();
  }

  /// Empty: there is none, and none will come.
  Job next() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return ending_ || !jobs_.empty(); });
    if (jobs_.empty()) return {};
    auto job = std::move(jobs_.front());
    jobs_.pop_front();
    return job;
  }

  std::mutex mutex_;
  std::condition_variable changed_;
  std::deque<Job> jobs_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses all above
};

}  // namespace

Result<std::unique_ptr<Worker>> start_worker(const std::string& name) {
  try {
    return std::make_unique<ThreadWorker>(name);
  } catch (const std::system_error& error) {
    return fail(ErrorCode::kIo, fmt::format("starting the thread {}: {}", name, error.code().message()));
  }
}

namespace {

auto no_files(const std::string& path) {
  return fail(ErrorCode::kUnsupported, path + ": this transport cannot write files");
}

}  // namespace

Result<std::unique_ptr<LocalStream>> Transports::open_local(const std::string& path, LocalCallbacks) {
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

Result<std::string> read_text(Transports& transports, const std::string& path, std::size_t largest) {
  auto file = transports.open_file(path);
  if (!file) return fail(file.error());
  const auto too_large = [&](std::uint64_t size) {
    return fail(ErrorCode::kOutOfRange, fmt::format("{}: {} bytes, expected at most {}", path, size, largest));
  };
  if ((*file)->size() > largest) return too_large((*file)->size());
  std::string text;
  Bytes piece(65536);
  while (true) {
    const auto count = (*file)->read(piece);
    if (!count) return fail(count.error());
    if (*count == 0) return text;
    text += base::as_text(ByteView(piece).first(*count));
    if (text.size() > largest) return too_large(text.size());
  }
}

std::string to_string(const Endpoint& endpoint) {
  const bool six = endpoint.address.find(':') != std::string::npos;
  return six ? fmt::format("[{}]:{}", endpoint.address, endpoint.port)
             : fmt::format("{}:{}", endpoint.address.empty() ? "*" : endpoint.address, endpoint.port);
}

// NOLINTBEGIN(performance-unnecessary-value-param): those that have sockets keep what they are given
Result<std::unique_ptr<UdpSocket>> Transports::open_udp(const UdpOptions&, UdpCallbacks) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

Result<std::unique_ptr<TcpStream>> Transports::open_tcp(const TcpOptions&, TcpCallbacks) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

Result<std::unique_ptr<TcpListener>> Transports::listen_tcp(const Endpoint&, TcpAccept, ListenerFailed) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

Result<std::unique_ptr<ByteStream>> Transports::open_serial(const SerialOptions&, StreamCallbacks) {
  return fail(ErrorCode::kUnsupported, "this transport has no serial lines");
}

Result<std::unique_ptr<ByteStream>> Transports::make_pty(const std::string&, StreamCallbacks) {
  return fail(ErrorCode::kUnsupported, "this transport has no serial lines");
}

Result<std::unique_ptr<MqttLine>> Transports::open_mqtt(const MqttOptions&, MqttCallbacks) {
  return fail(ErrorCode::kUnsupported, "this transport has no sockets");
}

std::unique_ptr<Lookup> Transports::look_up(const std::string&, LookupDone) {
  base::assertion_failed("names are looked up where there are sockets", __FILE__, __LINE__);
}
// NOLINTEND(performance-unnecessary-value-param)

}  // namespace rubicon::transport
