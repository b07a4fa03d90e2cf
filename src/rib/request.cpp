#include "rib/request.h"

namespace kinora::rib {

namespace {

// Buffers of ordinary size are kept for the next request; those of a large mesh are given back.
constexpr size_t kKeep = 1 << 16;

template <class T>
void reset(std::vector<T>& v) {
  if (v.capacity() > kKeep)
    std::vector<T>().swap(v);
  else
    v.clear();
}

}  // namespace

void Argument::clear() {
  kind = Kind::Numbers;
  isArray = false;
  isInteger = true;
  notFinite = false;
  reset(ints);
  reset(floats);
  exact.clear();
  reset(strings);
}

void Argument::becomeFloats() {
  floats.assign(ints.begin(), ints.end());
  reset(ints);
  isInteger = false;
}

Argument& Request::add(uint32_t line) {
  if (count == args.size()) args.emplace_back();
  Argument& a = args[count++];
  a.clear();
  a.line = line;
  return a;
}

}  // namespace kinora::rib
