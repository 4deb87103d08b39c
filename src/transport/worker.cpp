#include "transport/worker.h"

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

}  // namespace rubicon::transport
