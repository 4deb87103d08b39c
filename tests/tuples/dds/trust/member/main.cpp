// One process of a realm: `dds-member honest|liar ID FOLDER GUARD NAME IDS [LEASE_MS]`, FOLDER `none` = without trust.
// Obeys lines of standard input; `until CONDITION` answers `yes CONDITION` when it holds.
#include <poll.h>
#include <unistd.h>

#include <array>
#include <iostream>

#include "tuples/dds/trust/member/liar.h"

namespace {

using namespace rubicon;
using namespace rubicon::tuples::dds;

/// What arrived of standard input; false at its end.
bool take_lines(int wait_ms, std::string& pending, std::vector<std::string>& lines) {
  pollfd input{0, POLLIN, 0};
  if (::poll(&input, 1, wait_ms) <= 0) return true;
  std::array<char, 4096> part{};
  const auto count = ::read(0, part.data(), part.size());
  if (count <= 0) return false;
  pending.append(part.data(), static_cast<std::size_t>(count));
  for (auto end = pending.find('\n'); end != pending.npos; end = pending.find('\n')) {
    lines.push_back(pending.substr(0, end));
    pending.erase(0, end + 1);
  }
  return true;
}

int lie(GuardTrust& trust, OwnerId id, const std::string& partition) {
  Liar liar(trust, id, partition);
  std::cout << (liar.good() ? "ready" : "refused") << std::endl;
  for (std::string line; std::getline(std::cin, line);) {
    liar.obey(words_of(line));
    std::cout << "did " << line << std::endl;
  }
  return 0;
}

int live(OwnerId id, Duration lease, const std::shared_ptr<GuardTrust>& trust) {
  auto loop = std::move(*transport::PollLoop::make());
  KeptLog log;
  Honest member(*loop, log, trust);
  if (const auto started = member.start(id, lease); !started) {
    std::cout << "error " << started.error().text << std::endl;
    return 1;
  }
  std::cout << "ready" << std::endl;
  std::string pending;
  std::vector<std::string> lines, waiting;
  while (take_lines(0, pending, lines)) {
    loop->wait(std::chrono::milliseconds(1));
    loop->poll();
    for (const auto& line : std::exchange(lines, {})) {
      if (line.starts_with("until ")) {
        waiting.push_back(line.substr(6));
      } else {
        member.obey(words_of(line));
      }
    }
    std::erase_if(waiting, [&](const auto& condition) {
      const bool now = member.holds(words_of(condition));
      if (now) std::cout << "yes " << condition << std::endl;
      return now;
    });
  }
  return 0;
}

}  // namespace

int main(int count, char** values) {
  const std::vector<std::string> words(values, values + count);
  if (words.size() < 7) return 2;
  tuples::Member own;
  own.name = words[5];
  own.ids = ranges_of(words[6]);
  const auto trust = words[3] == "none" ? nullptr : std::make_shared<GuardTrust>(words[3], words[4], std::move(own));
  const OwnerId id{static_cast<std::uint32_t>(std::stoul(words[2]))};
  const auto lease = std::chrono::milliseconds(words.size() > 7 ? std::stoi(words[7]) : 2000);
  return words[1] == "liar" ? lie(*trust, id, words[6].substr(0, 8)) : live(id, lease, trust);
}
