#include "tuples/dds/former_domain.h"

#include <system_error>
#include <utility>

#include "wire.h"

namespace rubicon::tuples::dds {

namespace {

constexpr Duration kReadPause = std::chrono::milliseconds(2);

}  // namespace

FormerDomain::FormerDomain(Remains remains, Scheduler& scheduler, DdsEcology::Post post, std::function<void()> deleted)
    : remains_(std::move(remains)),
      scheduler_(scheduler),
      deleted_(std::make_shared<std::function<void()>>(std::move(deleted))) {
  const auto remove = [domain = remains_.domain.get(), done = done_, post = std::move(post),
                       call = std::weak_ptr(deleted_)] {
    dds_delete(domain);
    *done = true;
    post([call] {
      if (const auto tell = call.lock()) (*tell)();
    });
  };
  try {
    thread_ = std::thread(remove);
    read_soon();
  } catch (const std::system_error&) {
    remove();  // the system has no thread to give
  }
}

FormerDomain::~FormerDomain() {
  while (!is_deleted()) {
    read();
    dds_sleepfor(DDS_MSECS(1));
  }
  if (thread_.joinable()) thread_.join();
}

void FormerDomain::read() {
  for (const auto reader : remains_.frame_readers)
    take<rubicon_wire_Frame>(reader, SIZE_MAX, [](const auto&, const auto&) {});
}

void FormerDomain::read_soon() {
  timer_ = scheduler_.after(kReadPause, [this] {
    if (is_deleted()) return;
    read();
    read_soon();
  });
}

}  // namespace rubicon::tuples::dds
