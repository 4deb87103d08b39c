#pragma once

#include <functional>
#include <memory>
#include <vector>

#include "client/tuple_query.h"
#include "web/api/context.h"
#include "web/exchange.h"

namespace rubicon::web::api {

/// Answers a request with what the present tuples of some patterns say: each once, by owner and key.
class TupleRead final : public Exchange {
 public:
  using Make = std::function<Response(std::vector<client::Tuple> tuples)>;
  TupleRead(Context& context, const std::vector<Pattern>& patterns, Make make, Respond respond);

 private:
  void add(std::vector<client::Tuple> some);
  void merge();

  std::vector<client::Tuple> tuples_;
  std::size_t open_ = 0;
  Make make_;
  Respond respond_;
  std::vector<std::unique_ptr<client::TupleQuery>> queries_;
};

}  // namespace rubicon::web::api
