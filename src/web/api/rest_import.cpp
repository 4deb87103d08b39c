#include <fmt/format.h>

#include <utility>

#include "base/scheduler.h"
#include "base/text.h"
#include "model/json_members.h"
#include "model/point_keys.h"
#include "verbs/requests.h"
#include "web/api/route.h"
#include "web/exchange.h"
#include "web/importer.h"
#include "web/server/http_text.h"

namespace rubicon::web::api {

namespace {

/// Answers with what the importer says.
class ImportAnswer final : public Exchange {
 public:
  ImportAnswer(Importer& importer, ImportRequest request, Respond respond) : respond_(std::move(respond)) {
    importer.preview(std::move(request), lifetime_.guard([this](const Result<std::string>& preview) {
      const auto answer = std::move(respond_);
      answer(preview ? Response{.status = 200, .content_type = "application/json", .body = *preview}
                     : error_response(preview.error()));  // may destroy this
    }));
  }

 private:
  Respond respond_;
  base::Lifetime lifetime_;
};

/// A password is text for people, and a field of a head is not: it comes percent-encoded. It never stands in an
/// address.
constexpr std::string_view kPassword = "rubicon-password";

/// Of JSON {groups, choices}: the group file of an earlier answer, and what the user chose.
Result<void> read_choices(const std::string& body, ImportRequest& out) {
  const auto tree = verbs::parse_object(body);
  if (!tree) return fail(tree.error());
  const auto choices = tree->find("choices");
  const auto groups = model::find_text(*tree, "groups");
  if (!groups) return fail(ErrorCode::kInvalid, "groups is missing; expected a group file as text");
  if (choices == tree->end() || !choices->is_object())
    return fail(ErrorCode::kInvalid, "choices is missing; expected an object by address");
  out.content = *groups;
  out.name = "groups.yaml";
  out.choices = model::dump(*choices);
  return {};
}

Result<ImportRequest> read_import(Call& call) {
  ImportRequest out;
  out.network = call.query.text_or("network", "knx");
  out.name = call.query.text_or("name", "upload");
  out.guess = !call.query.flag("no-guess");
  if (auto good = call.query.end(); !good) return fail(good.error());
  const auto password = server::percent_decoded(call.request.header(kPassword));
  if (!password) return fail(ErrorCode::kInvalid, fmt::format("{} is not percent-encoded UTF-8", kPassword));
  out.password = *password;
  if (call.request.body.empty()) return fail(ErrorCode::kInvalid, "the file is empty");
  if (call.request.header("content-type").starts_with("application/json")) {
    if (auto good = read_choices(call.request.body, out); !good) return fail(good.error());
  } else {
    out.content = call.request.body;
  }
  return out;
}

}  // namespace

std::unique_ptr<Exchange> preview_import(Call& call) {
  const auto& caller = call.request.caller;
  const auto key = model::IslandKey{"proxy"}.settings().command();
  if (auto good = call.context.permission.check_role(caller, Verb::kSet, call.context.options.island, key); !good)
    return call.refuse(good.error());
  if (auto good = call.take_command(); !good) return call.refuse(good.error());
  auto request = read_import(call);
  if (!request) return call.refuse(request.error());
  auto* importer = call.context.options.importer;
  if (importer == nullptr)
    return call.refuse({ErrorCode::kUnsupported, "only the page of an island reads projects: ask there"});
  return std::make_unique<ImportAnswer>(*importer, std::move(*request), call.respond);
}

}  // namespace rubicon::web::api
