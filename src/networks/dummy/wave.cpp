#include "networks/dummy/wave.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace rubicon::networks::dummy {

namespace {

using model::DataType;

/// Largest step of a random walk, as a share of the span.
constexpr double kStride = 0.1;

bool is_numeric(const Type& type) {
  return type.data == DataType::kReal || type.data == DataType::kInteger;
}

double walk(Wave::Chance& chance) {
  chance.position = std::clamp(chance.position + kStride * (2 * chance.random.next() - 1), 0.0, 1.0);
  return chance.position;
}

}  // namespace

/// SplitMix64 (Steele, Lea, Flood: Fast splittable pseudorandom number generators, 2014).
double Random::next() {
  std::uint64_t z = state_ += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return static_cast<double>((z ^ (z >> 31)) >> 11) * 0x1p-53;
}

/// FNV-1a over the text, started with the seed.
std::uint64_t seed_of(std::uint64_t seed, std::string_view text) {
  std::uint64_t hash = 0xcbf29ce484222325 ^ seed;
  for (const char c : text) hash = (hash ^ static_cast<std::uint8_t>(c)) * 0x100000001b3;
  return hash;
}

Wave Wave::read(ConfigReader& options, const Type& type) {
  Wave wave(type);
  const bool shaped = is_numeric(type) || type.data == DataType::kBoolean;
  const std::string shape = options.choice("wave", options.has("values") ? "steps" : "constant",
                                           {"constant", "sine", "square", "sawtooth", "random", "steps"});
  wave.shape_ = shape == "sine"       ? Shape::kSine
                : shape == "square"   ? Shape::kSquare
                : shape == "sawtooth" ? Shape::kSawtooth
                : shape == "random"   ? Shape::kRandom
                : shape == "steps"    ? Shape::kSteps
                                      : Shape::kConstant;
  wave.period_ = options.duration("period", std::chrono::minutes(1));
  if (wave.period_ <= Duration::zero()) options.error("period", "expected more than 0s");
  if (shaped) wave.read_levels(options);
  if (wave.shape_ == Shape::kSteps || wave.shape_ == Shape::kConstant)
    wave.read_steps(options);
  else if (!shaped)
    options.error("wave", "is a shape for numbers and booleans, expected constant or steps for this type");
  return wave;
}

void Wave::read_levels(ConfigReader& options) {
  const double low = std::isfinite(type_->minimum) ? type_->minimum : 0;
  const double high = std::isfinite(type_->maximum) ? type_->maximum : low + 1;
  low_ = options.real("low", low, type_->minimum, type_->maximum);
  high_ = options.real("high", std::max(high, low_), type_->minimum, type_->maximum);
  noise_ = options.real("noise", 0, 0);
  if (low_ > high_) options.error("high", "is below low");
  const double span = high_ - low_;
  if (span > 0) decimals_ = std::clamp(2 - static_cast<int>(std::floor(std::log10(span))), 0, 6);
}

void Wave::read_steps(ConfigReader& options) {
  const bool constant = shape_ == Shape::kConstant;
  const char* key = constant ? "value" : "values";
  for (const std::string& text : options.texts(key)) {
    auto value = TypeCatalogue::parse(*type_, text);
    if (!value) options.error(key, value.error().text);
    steps_.push_back(value.value_or(Value{}));
  }
  const bool has_levels = is_numeric(*type_) || type_->data == DataType::kBoolean;
  if (steps_.empty() && constant && has_levels) steps_.push_back(value_of(low_));
  if (steps_.empty()) options.error(key, constant ? "missing, expected a value" : "missing, expected a list of values");
  if (constant && steps_.size() > 1) options.error(key, "expected one value; several are steps");
}

Value Wave::at(Duration since, Chance& chance) const {
  if (shape_ != Shape::kSteps && shape_ != Shape::kConstant) return value_of(number_at(since, chance));
  const auto step = static_cast<std::size_t>(since / period_);
  const Value& value = steps_[step % steps_.size()];
  const auto* number = std::get_if<double>(&value);
  return number != nullptr && noise_ > 0 ? value_of(*number + noise_ * (2 * chance.random.next() - 1)) : value;
}

double Wave::number_at(Duration since, Chance& chance) const {
  const double phase = static_cast<double>((since % period_).count()) / static_cast<double>(period_.count());
  double share = 0;
  switch (shape_) {
    case Shape::kSine: share = 0.5 + 0.5 * std::sin(2 * std::numbers::pi * phase); break;
    case Shape::kSquare: share = phase < 0.5 ? 0 : 1; break;
    case Shape::kSawtooth: share = phase; break;
    default: share = walk(chance); break;
  }
  const double noise = noise_ > 0 ? noise_ * (2 * chance.random.next() - 1) : 0;
  return low_ + share * (high_ - low_) + noise;
}

Value Wave::level(bool high) const {
  return value_of(high ? high_ : low_);
}

Value Wave::value_of(double number) const {
  if (type_->data == DataType::kBoolean) return number >= (low_ + high_) / 2 && number > low_;
  const double within = std::clamp(number, type_->minimum, type_->maximum);
  if (type_->data == DataType::kInteger) return static_cast<std::int64_t>(std::llround(within));
  const double scale = std::pow(10.0, decimals_);
  return std::clamp(std::round(within * scale) / scale, type_->minimum, type_->maximum);
}

}  // namespace rubicon::networks::dummy
