// Closures of programs that look at them, point by point.
#include "language/library/text.h"
#include "language/vm/closures.h"
#include "language/vm/scalar.h"

namespace kinora::language {

namespace {

std::string numberText(float x) {
  static const std::vector<FormatPiece> kFormat = parseFormat("%g");
  const FormatArgument a = formatFloats(&x);
  return formatText(kFormat, &a);
}

std::string listText(const std::vector<std::string>& parts) {
  std::string all;
  for (const std::string& p : parts) all += (all.empty() ? "" : ", ") + p;
  return all;
}

// One element of an argument.
std::string elementText(const Call& call, uint32_t k, uint32_t i, uint32_t first, uint32_t components) {
  if (call.base(k) == Base::String) return "\"" + call.text(k, i, first) + "\"";
  if (call.base(k) == Base::Int) return std::to_string(call.integer(k, i, first));
  std::vector<std::string> parts;
  for (uint32_t c = 0; c < components; ++c) parts.push_back(numberText(call.number(k, i, first + c)));
  return components == 1 ? parts[0] : "(" + listText(parts) + ")";
}

std::string argumentText(const Call& call, uint32_t k, uint32_t i, const ClosureTable& table, bool isClosure) {
  const uint32_t components = std::max(1u, uint32_t(componentsOf(call.base(k))));
  std::vector<std::string> elements;
  for (uint32_t first = 0; first < call.cells(k); first += components)
    elements.push_back(isClosure ? table.text(call.integer(k, i, first))
                                 : elementText(call, k, i, first, components));
  return call.isArray(k) ? "[" + listText(elements) + "]" : listText(elements);
}

bool hasRoom(const Call& call, uint32_t i) {
  if (!call.f.run->closures.isFull()) return true;
  tellOnce(call.f, call.siteNumber(), i,
           "too many closures; there are none from here on: " + placeOf(*call.f.run->program, call.site()));
  return false;
}

}  // namespace

int32_t ClosureTable::add(Entry entry) {
  if (isFull()) return 0;
  entries_.push_back(std::move(entry));
  return int32_t(entries_.size());
}
int32_t ClosureTable::make(std::string text) {
  Entry e;
  e.made = std::move(text);
  return add(std::move(e));
}
int32_t ClosureTable::sum(int32_t a, int32_t b) {
  if (a == 0 || b == 0) return a + b;
  Entry e;
  e.a = a;
  e.b = b;
  return add(std::move(e));
}
int32_t ClosureTable::scaled(int32_t a, const Weight& weight) {
  if (a == 0 || weight == Weight{0, 0, 0}) return 0;
  if (weight == Weight{1, 1, 1}) return a;
  Entry e;
  e.a = a;
  e.weight = weight;
  return add(std::move(e));
}

std::string ClosureTable::text(int32_t closure) const {
  std::string all;
  std::vector<std::pair<int32_t, Weight>> open;
  if (closure > 0) open.emplace_back(closure, Weight{1, 1, 1});
  for (size_t terms = 0; !open.empty();) {
    const auto [number, weight] = open.back();
    open.pop_back();
    if (number <= 0 || size_t(number) > entries_.size()) continue;
    const Entry& e = entries_[size_t(number) - 1];
    if (e.b != 0) {
      open.emplace_back(e.b, weight);
      open.emplace_back(e.a, weight);
    } else if (e.a != 0) {
      open.emplace_back(e.a, Weight{weight[0] * e.weight[0], weight[1] * e.weight[1], weight[2] * e.weight[2]});
    } else if (++terms > kMostTerms) {
      return all + "\n\t+ ...";
    } else {
      if (!all.empty()) all += "\n\t+ ";
      all += "(" + listText({numberText(weight[0]), numberText(weight[1]), numberText(weight[2])}) + ") * " + e.made;
    }
  }
  return all;
}

// result, name, which parameters are closures, parameters
void scalarClosureMake(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  ClosureTable& table = f.run->closures;
  eachLive(call, [&](uint32_t i) {
    if (!hasRoom(call, i)) return call.set(0, i, int32_t(0));
    const auto closures = uint32_t(call.integer(2, i));
    std::vector<std::string> parameters;
    for (uint32_t k = 3; k < call.count(); ++k)
      parameters.push_back(argumentText(call, k, i, table, k < 35 && (closures >> (k - 3) & 1)));
    call.set(0, i, table.make(call.text(1, i) + " (" + listText(parameters) + ")"));
  });
}
void scalarClosureAdd(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    hasRoom(call, i);
    call.set(0, i, f.run->closures.sum(call.integer(1, i), call.integer(2, i)));
  });
}
void scalarClosureMul(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    hasRoom(call, i);
    ClosureTable::Weight weight;
    for (uint32_t c = 0; c < 3; ++c) {
      const uint32_t from = call.cells(2) == 3 ? c : 0;
      weight[c] = call.base(2) == Base::Int ? float(call.integer(2, i, from)) : call.number(2, i, from);
    }
    call.set(0, i, f.run->closures.scaled(call.integer(1, i), weight));
  });
}
void scalarClosureText(const Frame& f, const uint32_t* w) {
  const Call call{f, w};
  eachLive(call, [&](uint32_t i) {
    for (uint32_t k = 0; k < call.cells(0) && k < call.cells(1); ++k)
      call.set(0, i, internString(f.run->closures.text(call.integer(1, i, k))), k);
  });
}

}  // namespace kinora::language
