#include <fmt/format.h>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/tuple_text.h"
#include "base/bytes.h"
#include "base/local_time.h"
#include "model/json_members.h"
#include "tuples/tuple_json.h"

namespace rubicon::cli {

namespace {

constexpr Duration kLastWords = std::chrono::milliseconds(300);

struct ReceiveOptions {
  AsOptions as;
  std::string type, length;
  std::size_t count = 0;
  bool hex = false, raw = false;
};

Line json_of(const client::UserMessage& message, WallTime now) {
  Line line;
  line["time"] = base::iso_text(now);
  line["from"] = number(message.from);
  if (!message.device.empty()) line["network"] = message.network;
  if (!message.device.empty()) line["device"] = message.device;
  line["type"] = message.type;
  if (base::is_utf8(message.bytes)) {
    line["text"] = message.bytes;
  } else {
    line["hex"] = base::to_hex(base::as_bytes(message.bytes));
  }
  return line;
}

/// `70001`, or `6541 wsn-1/7` for a device of an island.
std::string sender_of(const client::UserMessage& message) {
  const auto id = std::to_string(number(message.from));
  return message.device.empty() ? id : fmt::format("{} {}/{}", id, message.network, message.device);
}

void show(Session& session, const client::UserMessage& message, const ReceiveOptions& options) {
  auto& out = session.out();
  if (session.json()) return out.line(model::dump(json_of(message, session.now())));
  if (options.raw) return out.write(message.bytes);
  const bool hex = options.hex || !base::is_utf8(message.bytes);
  const auto text = hex ? base::to_hex(base::as_bytes(message.bytes)) : printable(message.bytes);
  out.line(fmt::format("{}  {}  {}: {}", clock_text(session.now()), printable(sender_of(message)),
                       printable(message.type), text));
}

int receive(Session& session, const ReceiveOptions& options) {
  std::size_t received = 0;
  auto listening = session.client().on_message(options.type, [&](const client::UserMessage& message) {
    if (options.count > 0 && received >= options.count) return;
    ++received;
    show(session, message, options);
  });
  print_error(fmt::format("waiting as {} for messages {}", number(session.client().id()),
                          options.type.empty() ? "of every type" : "of type " + printable(options.type)));
  session.run([&] { return options.count > 0 && received >= options.count; },
              parse_duration_or(options.length, Duration::max()));
  // Gives the sender of the last message its acknowledgement before the program ends; later messages are refused.
  listening = {};
  if (received > 0) session.run([] { return false; }, kLastWords);
  return received == 0 && !session.interrupted() ? kNotThere : kGood;
}

}  // namespace

void add_receive(Cli& cli) {
  const auto options = std::make_shared<ReceiveOptions>();
  auto* app = cli.command({"receive", "Show the messages that others send to this program, line by line",
                           "  rubicon receive --type chat --name kitchen     # rubicon send kitchen --type chat hello\n"
                           "  rubicon receive --id 70001 --count 1 --for 10min --json\n"
                           "Exit code 8: no message came in the time of --for.\n"},
                          [options](const Settings& settings) {
                            const auto session = Session::open(options->as.applied(settings), "receive");
                            return session ? session->end(receive(*session, *options)) : static_cast<int>(kFailed);
                          });
  app->add_option("--type", options->type, "messages of this type only; of every type if not given");
  options->as.add_to(*app);
  add_duration_option(app, "--for", options->length, "end after this time");
  app->add_option("--count", options->count, "end after so many messages")->type_name("N")->check(CLI::PositiveNumber);
  auto* hex = app->add_flag("--hex", options->hex, "show the bytes in hex");
  app->add_flag("--raw", options->raw, "nothing but the bytes, as they came")->excludes(hex);
}

}  // namespace rubicon::cli
