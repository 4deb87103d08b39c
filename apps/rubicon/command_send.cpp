#include <fmt/format.h>

#include <cstdio>
#include <memory>

#include "apps/rubicon/cli.h"
#include "apps/rubicon/island_option.h"
#include "apps/rubicon/tuple_text.h"
#include "base/bytes.h"
#include "model/json_members.h"

namespace rubicon::cli {

namespace {

/// What an island takes (docs/gateway.cddl) with room for the rest of the message.
constexpr std::size_t kMostBytes = 1000UL * 1000;

struct SendOptions {
  std::string to, type = "text", file, network, device;
  std::optional<std::string> text;
  bool hex = false;
};

Result<std::string> words(const SendOptions& options) {
  if (!options.text && options.file.empty())
    return fail(ErrorCode::kInvalid, "nothing to send, expected TEXT, - or --file");
  if (options.text && *options.text != "-") return *options.text;
  const bool standard = options.file.empty() || options.file == "-";
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(
      standard ? stdin : std::fopen(options.file.c_str(), "rb"),  // NOLINT(cppcoreguidelines-owning-memory)
      [](std::FILE* one) { return one == stdin ? 0 : std::fclose(one); });
  if (!file) return fail(ErrorCode::kIo, fmt::format("{}: cannot be opened", options.file));
  std::string bytes(kMostBytes + 1, '\0');
  bytes.resize(std::fread(bytes.data(), 1, bytes.size(), file.get()));
  if (std::ferror(file.get())) return fail(ErrorCode::kIo, fmt::format("{}: cannot be read", options.file));
  if (bytes.size() > kMostBytes)
    return fail(ErrorCode::kOutOfRange, fmt::format("a message has at most {} bytes", kMostBytes));
  return bytes;
}

Result<std::string> content(const SendOptions& options) {
  auto text = words(options);
  if (!text || !options.hex) return text;
  std::erase_if(*text, [](char letter) { return letter == '\n' || letter == '\r'; });
  const auto bytes = base::from_hex(*text);
  if (!bytes) return fail(bytes.error());
  return std::string(base::as_text(*bytes));
}

int tell(Session& session, OwnerId to, std::size_t bytes, const std::string& why_not) {
  if (session.json()) {
    session.out().line(
        model::dump({{"to", number(to)}, {"bytes", bytes}, {"ok", why_not.empty()}, {"reason", why_not}}));
  } else if (why_not.empty()) {
    session.out().line(fmt::format("sent {} to {}", counted(bytes, "byte"), session.component_text(to)));
  } else {
    print_error(fmt::format("{} did not take it: {}", session.component_text(to), printable(why_not)));
  }
  return why_not.empty() ? kGood : kRefused;
}

int send(Session& session, const SendOptions& options) {
  const auto bytes = content(options);
  if (!bytes) {
    print_error(bytes.error().text);
    return bytes.error().code == ErrorCode::kIo ? kFailed : kUsage;
  }
  const auto found = components_called(session, options.to);
  if (found.empty()) return session.not_found(fmt::format("no component {}", model::quoted(options.to)));
  if (found.size() > 1) {
    std::string ids;
    for (const auto id : found) ids += fmt::format(" {}", number(id));
    print_error(fmt::format("{} is the name of several components; use an id:{}", model::quoted(options.to), ids));
    return kUsage;
  }
  std::optional<std::string> answer;
  const auto heard = [&answer](const std::string& why_not) { answer = why_not; };
  auto& client = session.client();
  if (!options.device.empty()) {
    client.send_to_device(found[0], options.network, options.device, options.type, *bytes, heard);
  } else {
    client.send_to_network(found[0], options.network, options.type, *bytes, heard);  // none: to the component itself
  }
  if (session.run([&] { return answer.has_value(); }, session.settings().patience + std::chrono::seconds(5)))
    return tell(session, found[0], bytes->size(), *answer);
  print_error(fmt::format("{} did not answer", session.component_text(found[0])));
  return kTimedOut;
}

}  // namespace

void add_send(Cli& cli) {
  const auto options = std::make_shared<SendOptions>();
  auto* app =
      cli.command_in_ecology({"send", "Send a message of a type to a component",
                              "  rubicon send 70001 --type chat 'come to the kitchen'\n"
                              "  rubicon send 6541 --type image --file map.png\n"
                              "  date | rubicon send robot --type clock -\n"
                              "  rubicon send 6541 --network wsn-1 --device 7 --type mote/3/6/1 --hex 01012cbeef\n"},
                             [options](Session& session) { return send(session, *options); });
  app->add_option("COMPONENT", options->to, "id or name of an island or another component")->required();
  auto* text = app->add_option("TEXT", options->text, "the message; - = standard input");
  app->add_option("--type", options->type, "your word for what it is")->capture_default_str();
  app->add_option("--file", options->file, "send what is in this file")->excludes(text);
  app->add_flag("--hex", options->hex, "TEXT, input or file are bytes in hex");
  app->add_option("--device", options->device, "to a device of the island, by its address");
  app->add_option("--network", options->network,
                  "to a network of the island, or its device where several have that address");
}

}  // namespace rubicon::cli
