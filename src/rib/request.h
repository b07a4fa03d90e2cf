// One request with its arguments as they stand in the stream, before anything is known of their meaning. Filled by
// the lexer, kept by inline archives and motion blocks, consumed by the interpreter. Buffers are reused from request
// to request.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "base/diagnostics.h"

namespace kinora::rib {

struct Argument {
  enum class Kind : uint8_t { Numbers, Strings };
  Kind kind = Kind::Numbers;
  bool isArray = false;    // was in brackets
  bool isInteger = true;   // all numbers were written as integers: values are in `ints`, else in `floats`
  bool notFinite = false;  // a number was nan or too large for a float; it is NaN or infinite in `floats`
  uint32_t line = 0;
  std::vector<int> ints;
  std::vector<float> floats;
  std::vector<double> exact;  // the first kExact numbers in full precision, for transforms and times
  std::vector<std::string> strings;
  static constexpr size_t kExact = 8192;
  static constexpr size_t kExactKept = 32;  // in requests that are recorded, but for times

  size_t size() const { return kind == Kind::Strings ? strings.size() : isInteger ? ints.size() : floats.size(); }
  bool isString() const { return kind == Kind::Strings && strings.size() == 1; }
  void clear();
  void addInteger(int v) {
    if (!isInteger)
      floats.push_back(float(v));
    else
      ints.push_back(v);
    if (exact.size() < kExact) exact.push_back(v);
  }
  void addReal(double v) {
    if (isInteger) becomeFloats();
    const float f = float(v);
    notFinite |= !(f - f == 0);
    floats.push_back(f);
    if (exact.size() < kExact) exact.push_back(v);
  }
  void becomeFloats();
};

struct Request {
  std::string name;
  SourcePos pos;
  std::vector<Argument> args;  // only the first `count` are in use
  size_t count = 0;

  void clear() { count = 0; }
  Argument& add(uint32_t line);
};

}  // namespace kinora::rib
