#include <array>
#include <string>

#include "model/json_members.h"
#include "web/api/route.h"

namespace rubicon::web::api {

namespace {

using Json = nlohmann::ordered_json;

bool is_in_path(const Route& route, const Parameter& parameter) {
  return std::string_view(route.path).find("{" + std::string(parameter.name) + "}") != std::string_view::npos;
}

Json parameter_json(const Route& route, const Parameter& parameter) {
  Json tree;
  tree["name"] = parameter.name;
  tree["in"] = is_in_path(route, parameter) ? "path" : "query";
  tree["required"] = parameter.required;
  tree["description"] = parameter.about;
  tree["schema"] = {{"type", parameter.type}};
  if (*parameter.example != '\0') tree["example"] = parameter.example;
  return tree;
}

Json responses_json(const Route& route) {
  Json responses;
  for (const auto& answer : route.answers) {
    auto& response = responses[std::to_string(answer.status)];
    if (!response.contains("description")) response["description"] = answer.about;
    const bool is_error = answer.status >= 400;
    const Json schema = is_error ? Json{{"$ref", "#/components/schemas/Error"}} : Json::object();
    response["content"][answer.media_type] = {{"schema", schema}};
  }
  if (!route.is_open) responses["401"] = {{"$ref", "#/components/responses/NoToken"}};
  return responses;
}

Json operation_json(const Route& route) {
  Json operation;
  operation["summary"] = route.summary;
  for (const auto& parameter : route.parameters) operation["parameters"].push_back(parameter_json(route, parameter));
  if (*route.body != '\0')
    operation["requestBody"] = {{"required", true}, {"content", {{route.body, {{"schema", Json::object()}}}}}};
  operation["responses"] = responses_json(route);
  if (route.is_open) operation["security"] = Json::array();
  return operation;
}

Json components_json() {
  Json error;
  error["type"] = "object";
  error["required"] = {"error"};
  error["properties"]["error"] = {{"type", "object"},
                                  {"required", {"code", "text"}},
                                  {"properties", {{"code", {{"type", "string"}}}, {"text", {{"type", "string"}}}}}};
  Json components;
  components["schemas"]["Error"] = error;
  components["responses"]["NoToken"] = {
      {"description", "a token is needed"},
      {"content", {{"application/json", {{"schema", {{"$ref", "#/components/schemas/Error"}}}}}}}};
  components["securitySchemes"]["bearer"] = {{"type", "http"}, {"scheme", "bearer"}};
  return components;
}

std::string document(bool needs_token) {
  Json tree;
  tree["openapi"] = "3.1.0";
  tree["info"] = {{"title", "Rubicon"}, {"version", "1"}};
  tree["servers"] = {{{"url", "/"}}};
  for (const auto& route : routes()) {
    std::string method = route.method;
    for (auto& c : method) c = static_cast<char>(c - 'A' + 'a');
    tree["paths"][route.path][method] = operation_json(route);
  }
  tree["components"] = components_json();
  if (needs_token) tree["security"] = {{{"bearer", Json::array()}}};
  return model::dump(tree);
}

}  // namespace

/// It is the same as long as the program runs.
std::unique_ptr<Exchange> openapi(Call& call) {
  static const std::array<std::string, 2> kDocuments{document(false), document(true)};
  return call.answer({.status = 200,
                      .content_type = "application/json",
                      .body = kDocuments[call.context.access.rules().needs_token ? 1 : 0]});
}

}  // namespace rubicon::web::api
