#include "language/front/constants.h"

#include <cmath>

namespace kinora::language::front {

namespace {

// Out of range is what the CPUs that shaders were written on give.
int32_t truncated(float f) { return f >= -2147483648.f && f < 2147483648.f ? int32_t(f) : INT32_MIN; }

bool number(const Expr& e, float& f) {
  Values v;
  if (!isScalarNumber(e.type) || !constantOf(e, v)) return false;
  f = e.type.base == Base::Int ? float(v.ints[0]) : v.floats[0];
  return true;
}

bool binary(const Expr& e, Values& out) {
  const Type& t = e.type;
  if (e.function || !isScalarNumber(t) || !isScalarNumber(e.a->type) || !isScalarNumber(e.b->type)) return false;
  Values va, vb;
  if (t.base == Base::Int && e.a->type.base == Base::Int && e.b->type.base == Base::Int) {
    if (!constantOf(*e.a, va) || !constantOf(*e.b, vb)) return false;
    const auto a = uint32_t(va.ints[0]), b = uint32_t(vb.ints[0]);
    const int32_t ia = va.ints[0], ib = vb.ints[0];
    switch (e.op) {
      case Punct::Plus:
        out.ints = {int32_t(a + b)};
        return true;
      case Punct::Minus:
        out.ints = {int32_t(a - b)};
        return true;
      case Punct::Star:
        out.ints = {int32_t(a * b)};
        return true;
      case Punct::Slash:
        out.ints = {ib == 0 ? 0 : ib == -1 ? int32_t(0 - a) : ia / ib};
        return true;
      case Punct::Percent:
        out.ints = {ib == 0 || ib == -1 ? 0 : ia % ib};
        return true;
      case Punct::And:
        out.ints = {int32_t(a & b)};
        return true;
      case Punct::Or:
        out.ints = {int32_t(a | b)};
        return true;
      case Punct::Xor:
        out.ints = {int32_t(a ^ b)};
        return true;
      case Punct::ShiftLeft:
        if (b >= 32) return false;
        out.ints = {int32_t(a << b)};
        return true;
      case Punct::ShiftRight:
        if (b >= 32) return false;
        out.ints = {ia >> b};
        return true;
      default:
        return false;
    }
  }
  if (t.base != Base::Float) return false;
  float a, b;
  if (!number(*e.a, a) || !number(*e.b, b)) return false;
  switch (e.op) {
    case Punct::Plus:
      out.floats = {a + b};
      return true;
    case Punct::Minus:
      out.floats = {a - b};
      return true;
    case Punct::Star:
      out.floats = {a * b};
      return true;
    case Punct::Slash:
      out.floats = {b != 0 && std::isfinite(a / b) ? a / b : 0.f};
      return true;
    default:
      return false;
  }
}

bool construct(const Expr& e, Values& out) {
  const Type& t = e.type;
  std::vector<float> numbers;
  for (const Expr* a : e.list) {
    Values v;
    if (!constantOf(*a, v) || !isPlainNumber(a->type)) return false;
    v = converted(v, a->type, {a->type.base == Base::Int ? Base::Float : a->type.base, 0, -1});
    numbers.insert(numbers.end(), v.floats.begin(), v.floats.end());
  }
  if (e.list.size() == 1) {
    Values one;
    if (!constantOf(*e.list[0], one)) return false;
    out = converted(one, e.list[0]->type, t);
    return true;
  }
  if (int32_t(numbers.size()) != componentsOf(t.base)) return false;
  out.floats = std::move(numbers);
  return true;
}

bool array(const Expr& e, Values& out) {
  const Type element{e.type.base, 0, -1};
  for (const Expr* a : e.list) {
    Values v;
    if (!constantOf(*a, v)) return false;
    v = converted(v, a->type, element);
    out.ints.insert(out.ints.end(), v.ints.begin(), v.ints.end());
    out.floats.insert(out.floats.end(), v.floats.begin(), v.floats.end());
    out.strings.insert(out.strings.end(), v.strings.begin(), v.strings.end());
  }
  if (e.type.arrayLength > 0) {  // elements that the list leaves out
    const auto n = size_t(e.type.arrayLength);
    if (e.type.base == Base::Int)
      out.ints.resize(n);
    else if (e.type.base == Base::String)
      out.strings.resize(n);
    else
      out.floats.resize(n * size_t(componentsOf(e.type.base)));
  }
  return true;
}

}  // namespace

bool constantOf(const Expr& e, Values& out) {
  switch (e.kind) {
    case ExprKind::Int:
      out.ints = {e.intValue};
      return true;
    case ExprKind::Float:
      out.floats = {e.floatValue};
      return true;
    case ExprKind::String:
      out.strings = {std::string(e.text)};
      return true;
    case ExprKind::Unary:
      if (e.function || !isPlainNumber(e.type) || !constantOf(*e.a, out)) return false;
      if (e.op == Punct::Plus) return true;
      if (e.op == Punct::Minus) {
        for (float& f : out.floats) f = -f;
        for (int32_t& i : out.ints) i = int32_t(0 - uint32_t(i));
        return true;
      }
      if (e.op == Punct::Tilde && e.type.base == Base::Int) {
        out.ints[0] = ~out.ints[0];
        return true;
      }
      return false;
    case ExprKind::Binary:
      return binary(e, out);
    case ExprKind::Cast: {
      Values v;
      if (!isPlain(e.type) || !constantOf(*e.a, v)) return false;
      out = converted(v, e.a->type, e.type);
      return true;
    }
    case ExprKind::Construct:
      return construct(e, out);
    case ExprKind::List:
      if (e.type.base == Base::Struct || e.type.base == Base::Closure) return false;
      return e.type.arrayLength != 0 ? array(e, out) : construct(e, out);
    default:
      return false;
  }
}

Values converted(const Values& values, const Type& from, const Type& to) {
  Values out;
  if (from.base == to.base || (isTriple(from.base) && isTriple(to.base))) {
    out = values;
    if (to.arrayLength > 0) {
      const auto n = size_t(to.arrayLength);
      if (to.base == Base::Int)
        out.ints.resize(n);
      else if (to.base == Base::String)
        out.strings.resize(n);
      else
        out.floats.resize(n * size_t(componentsOf(to.base)));
    }
    return out;
  }
  if (to.base == Base::Int) {
    out.ints = {values.floats.empty() ? 0 : truncated(values.floats[0])};
    return out;
  }
  const float f = from.base == Base::Int ? (values.ints.empty() ? 0.f : float(values.ints[0]))
                                         : (values.floats.empty() ? 0.f : values.floats[0]);
  if (to.base == Base::Matrix) {
    out.floats.assign(16, 0.f);
    for (size_t i = 0; i < 16; i += 5) out.floats[i] = f;
  } else {
    out.floats.assign(size_t(componentsOf(to.base)), f);
  }
  return out;
}

Values zeros(const Type& type) {
  Values v;
  const auto n = size_t(type.arrayLength > 0 ? type.arrayLength : type.arrayLength < 0 ? 0 : 1);
  if (type.base == Base::Int)
    v.ints.assign(n, 0);
  else if (type.base == Base::String)
    v.strings.assign(n, "");
  else
    v.floats.assign(n * size_t(componentsOf(type.base)), 0.f);
  return v;
}

}  // namespace kinora::language::front
