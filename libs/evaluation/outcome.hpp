// A result or, where an evaluation can't be made, the reason in plain English.
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace fusion_slam {

template <typename T>
struct Outcome {
  std::optional<T> value;
  std::string problem;  // empty exactly when there is a value

  static Outcome success(T result) { return {std::move(result), {}}; }
  static Outcome failure(std::string reason) { return {std::nullopt, std::move(reason)}; }

  explicit operator bool() const { return value.has_value(); }
  const T& operator*() const { return *value; }
  const T* operator->() const { return &*value; }
};

}  // namespace fusion_slam
