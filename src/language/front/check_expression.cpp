// Types of expressions, but for calls.
#include "language/front/checker.h"
#include "language/front/constants.h"

namespace kinora::language::front {

namespace {

bool isScalar(const Type& t) { return isScalarNumber(t); }
bool isInt(const Type& t) { return isPlain(t) && t.base == Base::Int; }
bool isTripleValue(const Type& t) { return isPlain(t) && isTriple(t.base); }
bool isMatrix(const Type& t) { return isPlain(t) && t.base == Base::Matrix; }
bool isSimple(const Type& t) { return isPlain(t) && componentsOf(t.base) > 0; }
constexpr Type plain(Base b) { return {b, 0, -1}; }

std::string_view spelling(Punct op) {
  switch (op) {
    case Punct::Plus:
      return "+";
    case Punct::Minus:
      return "-";
    case Punct::Star:
      return "*";
    case Punct::Slash:
      return "/";
    case Punct::Percent:
      return "%";
    case Punct::And:
      return "&";
    case Punct::Or:
      return "|";
    case Punct::Xor:
      return "^";
    case Punct::AndAnd:
      return "&&";
    case Punct::OrOr:
      return "||";
    case Punct::ShiftLeft:
      return "<<";
    case Punct::ShiftRight:
      return ">>";
    case Punct::Equal:
      return "==";
    case Punct::NotEqual:
      return "!=";
    case Punct::Less:
      return "<";
    case Punct::LessEq:
      return "<=";
    case Punct::Greater:
      return ">";
    case Punct::GreaterEq:
      return ">=";
    case Punct::Not:
      return "!";
    case Punct::Tilde:
      return "~";
    default:
      return "?";
  }
}

Punct withoutAssign(Punct op) {
  switch (op) {
    case Punct::PlusAssign:
      return Punct::Plus;
    case Punct::MinusAssign:
      return Punct::Minus;
    case Punct::StarAssign:
      return Punct::Star;
    case Punct::SlashAssign:
      return Punct::Slash;
    case Punct::AndAssign:
      return Punct::And;
    case Punct::OrAssign:
      return Punct::Or;
    case Punct::XorAssign:
      return Punct::Xor;
    case Punct::ShiftLeftAssign:
      return Punct::ShiftLeft;
    case Punct::ShiftRightAssign:
      return Punct::ShiftRight;
    default:
      return Punct::None;
  }
}

}  // namespace

Type Checker::check(Expr* e, Type expected) {
  if (e->isChecked) return e->type;
  switch (e->kind) {
    case ExprKind::Bad:
      e->type = kPoison;
      break;
    case ExprKind::Int:
      if (e->intValue == INT32_MIN && !e->isPrefix)
        messages_.warning(e->pos, "the number 2147483648 does not fit into an int");
      e->type = plain(Base::Int);
      break;
    case ExprKind::Float:
      e->type = plain(Base::Float);
      break;
    case ExprKind::String:
      e->type = plain(Base::String);
      break;
    case ExprKind::Variable:
      e->type = variable(e);
      break;
    case ExprKind::Index:
      e->type = index(e);
      break;
    case ExprKind::Field:
      e->type = field(e);
      break;
    case ExprKind::Unary:
      e->type = unary(e, expected);
      break;
    case ExprKind::Binary:
      e->type = binary(e, expected);
      break;
    case ExprKind::Assign:
      e->type = assign(e);
      break;
    case ExprKind::Increment:
      e->type = increment(e);
      break;
    case ExprKind::Ternary:
      e->type = ternary(e, expected);
      break;
    case ExprKind::Cast:
      e->type = cast(e);
      break;
    case ExprKind::Construct:
      e->type = construct(e);
      break;
    case ExprKind::Call:
      e->type = call(e, expected);
      break;
    case ExprKind::List:
      if (expected.base == Base::Void) {
        if (!isPoison(expected)) error(e->pos, "a list in braces needs a type to be made from it");
        for (Expr* x : e->list)
          if (x->kind != ExprKind::List) check(x);
        e->type = kPoison;
      } else {
        e->type = list(e, expected);
      }
      break;
    case ExprKind::Comma:
      for (size_t i = 0; i + 1 < e->list.size(); ++i) check(e->list[i]);
      e->type = check(e->list.back(), expected);
      break;
  }
  return e->type;
}

Type Checker::checkAs(Expr* e, Type target, const char* what) {
  const Type t = check(e, target);
  if (isPoison(t) || isPoison(target)) return t;
  if (assignable(target, t)) return t;
  if (target.base == Base::Closure && isPlain(target) &&
      ((e->kind == ExprKind::Int && e->intValue == 0) || (e->kind == ExprKind::Float && e->floatValue == 0))) {
    e->kind = ExprKind::Int;  // 0.0 is none as well
    return e->type = plain(Base::Int);
  }
  if (target == plain(Base::Int) && t == plain(Base::Float)) {
    messages_.warning(e->pos, "assignment may lose precision: int = float");
    return t;
  }
  if (t == Type{}) {
    error(e->pos, "this has no value");
    return kPoison;
  }
  const std::string_view w = what;
  if (w == "return")
    error(e->pos, "cannot return '" + text(t) + "' as '" + text(target) + "'");
  else if (w == "metadata")
    error(e->pos, "cannot give metadata of type '" + text(target) + "' the value of a '" + text(t) + "'");
  else if (w == "initialise")
    error(e->pos, "cannot initialise '" + text(target) + "' with '" + text(t) + "'");
  else if (w == "element")
    error(e->pos, "cannot use '" + text(t) + "' as '" + text(target) + "' in this list");
  else
    error(e->pos, "cannot assign '" + text(t) + "' to '" + text(target) + "'");
  return kPoison;
}

Type Checker::list(Expr* e, Type target) {
  if (target.arrayLength != 0) {
    const Type element{target.base, 0, target.structure};
    bool isGood = true;
    for (Expr* x : e->list) isGood &= !isPoison(checkAs(x, element, "element"));
    if (!isGood) return kPoison;
    if (target.arrayLength > 0 && e->list.size() > size_t(target.arrayLength)) {
      error(e->list[size_t(target.arrayLength)]->pos, "too many values for '" + text(target) + "'");
      return kPoison;
    }
    if (target.arrayLength < 0) {
      if (e->list.empty()) {
        error(e->pos, "the array needs at least one value");
        return kPoison;
      }
      target.arrayLength = int32_t(e->list.size());
    }
    return target;
  }
  if (target.base == Base::Struct) {
    const Structure& s = structures_[size_t(target.structure)];
    const bool isConstructor =
        e->kind == ExprKind::Call;  // which takes all fields; a list may leave the last ones out
    if (e->list.size() > s.fields.size() || (isConstructor && e->list.size() < s.fields.size())) {
      error(e->pos, "struct '" + s.name + "' has " + std::to_string(s.fields.size()) + " fields, the list " +
                        std::to_string(e->list.size()) + (e->list.size() == 1 ? " value" : " values"));
      for (Expr* x : e->list)
        if (x->kind != ExprKind::List) check(x);
      return kPoison;
    }
    bool isGood = true;
    for (size_t i = 0; i < e->list.size(); ++i)
      isGood &= !isPoison(checkAs(e->list[i], structures_[size_t(target.structure)].fields[i].type, "element"));
    return isGood ? target : kPoison;
  }
  if (target.base == Base::Closure || target.base == Base::String) {
    if (e->list.size() == 1) return isPoison(checkAs(e->list[0], target, "element")) ? kPoison : target;
    error(e->pos, "a list is no '" + text(target) + "'");
    return kPoison;
  }
  e->spec.base = target.base;  // as a constructor
  return construct(e);
}

Type Checker::variable(Expr* e) {
  Var* v = find(e->name);
  if (!v) {
    const bool isFunction = functions_[e->name] || builtinNamed(names_.text(e->name));
    error(e->pos, "'" + text(e->name) + (isFunction ? "' is a function" : "' is not declared"));
    if (body_ && !isFunction) {  // once is enough
      v = pool_.make<Var>();
      v->name = e->name;
      v->pos = e->pos;
      v->type = kPoison;
      declare(v);
    }
    e->var = v;
    return kPoison;
  }
  if (v->kind == VarKind::Global && hasShader_ && !isReadable(v->globalIndex, kind_))
    messages_.warning(e->pos, "shaders of this kind have no '" + text(e->name) + "'");
  e->var = v;
  return v->type;
}

// A chain of indices is walked from what is indexed outwards: m[i] alone is nothing, m[i][j] one node that knows
// both.
Type Checker::index(Expr* e) {
  std::vector<Expr*> chain;
  for (Expr* x = e; x->kind == ExprKind::Index; x = x->a) chain.push_back(x);
  Type t = check(chain.back()->a);
  for (size_t n = chain.size(); n > 0; --n) {
    Expr* node = chain[n - 1];
    if (isMatrix(t) && (n > 1 || node->c)) {
      if (!node->c) {  // else it was checked before
        Expr* column = chain[--n - 1];
        column->c = column->b;
        column->b = node->b;
        column->a = node->a;
        node = column;
      }
      t = plain(Base::Float);
      for (Expr* x : {node->b, node->c}) {
        const Type i = check(x);
        if (!isPoison(i) && !isInt(i)) error(x->pos, "an index must be an int, not '" + text(i) + "'");
        if (!isInt(i)) t = kPoison;
      }
    } else {
      t = indexOf(node, t);
    }
    node->type = t;
  }
  return t;
}

// t: the type of what is indexed, which is checked.
Type Checker::indexOf(Expr* e, Type t) {
  const Type i = check(e->b);
  if (isPoison(t) || isPoison(i)) return kPoison;
  if (!isInt(i)) {
    error(e->b->pos, "an index must be an int, not '" + text(i) + "'");
    return kPoison;
  }
  if (uses_) use(text(t.arrayLength != 0 ? Type{t.base, -1, t.structure} : t) + " []");
  if (t.arrayLength != 0) return {t.base, 0, t.structure};
  if (isTriple(t.base)) return plain(Base::Float);
  if (t.base == Base::Matrix)
    error(e->pos, "a matrix takes two indices: m[row][column]");
  else
    error(e->pos, "a value of type '" + text(t) + "' has no elements");
  return kPoison;
}

Type Checker::field(Expr* e) {
  const Type t = check(e->a);
  if (isPoison(t)) return kPoison;
  if (isPlain(t) && t.base == Base::Struct) {
    const StructInfo& info = infos_[size_t(t.structure)];
    for (size_t i = 0; i < info.fields.size(); ++i)
      if (info.fields[i] == e->name) {
        e->field = int32_t(i);
        return structures_[size_t(t.structure)].fields[i].type;
      }
    error(e->pos, "struct '" + text(info.name) + "' has no field '" + text(e->name) + "'");
    return kPoison;
  }
  if (isTripleValue(t)) {
    const std::string_view n = names_.text(e->name), own = t.base == Base::Color ? "rgb" : "xyz";
    const size_t at = n.size() == 1 ? own.find(n[0]) : std::string_view::npos;
    if (at != std::string_view::npos) {
      if (uses_) use(text(t) + " ." + std::string(n));
      e->field = int32_t(at);
      return plain(Base::Float);
    }
    error(e->pos, "a value of type '" + text(t) + "' has no component '" + text(e->name) + "'");
    return kPoison;
  }
  error(e->pos, "a value of type '" + text(t) + "' has no field '" + text(e->name) + "'");
  return kPoison;
}

Type Checker::unary(Expr* e, Type expected) {
  if (e->op == Punct::Minus && e->a->kind == ExprKind::Int) e->a->isPrefix = true;  // -2147483648 is meant
  const Type t = check(e->a, e->op == Punct::Not ? Type{} : expected);
  if (isPoison(t)) return kPoison;
  Expr* operand[] = {e->a};
  if (e->op != Punct::Plus)
    if (Function* f = operatorFor(e, operand, expected)) return f->type;
  if (uses_) use(std::string(spelling(e->op)) + " " + text(t));
  switch (e->op) {
    case Punct::Not:
      if (!isCondition(t)) break;
      return plain(Base::Int);
    case Punct::Tilde:
      if (isInt(t)) return t;
      break;
    default:
      if (isPlainNumber(t)) return t;
      if (e->op == Punct::Plus && isPlain(t) && t.base == Base::Closure) return t;
  }
  error(e->pos, "operator " + std::string(spelling(e->op)) + " takes no '" + text(t) + "'");
  return kPoison;
}

// Void: there is no such operation.
Type Checker::binaryType(Punct op, const Type& a, const Type& b) const {
  switch (op) {
    case Punct::AndAnd:
    case Punct::OrOr:
      return isCondition(a) && isCondition(b) ? plain(Base::Int) : Type{};
    case Punct::Percent:
    case Punct::And:
    case Punct::Or:
    case Punct::Xor:
    case Punct::ShiftLeft:
    case Punct::ShiftRight:
      return isInt(a) && isInt(b) ? plain(Base::Int) : Type{};
    case Punct::Less:
    case Punct::LessEq:
    case Punct::Greater:
    case Punct::GreaterEq:
      return isScalar(a) && isScalar(b) ? plain(Base::Int) : Type{};
    case Punct::Equal:
    case Punct::NotEqual:
      if (!isSimple(a) || !isSimple(b)) return {};
      if (a.base == b.base || (isScalar(a) && isScalar(b))) return plain(Base::Int);
      if ((isTripleValue(a) || isScalar(a)) && (isTripleValue(b) || isScalar(b))) return plain(Base::Int);
      return (isMatrix(a) && isScalar(b)) || (isScalar(a) && isMatrix(b)) ? plain(Base::Int) : Type{};
    default:
      break;
  }
  if (isPlain(a) && isPlain(b) && (a.base == Base::Closure || b.base == Base::Closure)) {
    if (a.base == b.base) return op == Punct::Plus ? a : Type{};
    const Type& weight = a.base == Base::Closure ? b : a;
    return op == Punct::Star && (isScalar(weight) || isTripleValue(weight)) ? plain(Base::Closure) : Type{};
  }
  if (!isPlainNumber(a) || !isPlainNumber(b)) return {};
  if (isMatrix(a) || isMatrix(b)) {
    if (isTripleValue(a) || isTripleValue(b)) return {};
    return op == Punct::Star || op == Punct::Slash ? plain(Base::Matrix) : Type{};
  }
  if (isScalar(a) && isScalar(b)) return plain(isInt(a) && isInt(b) ? Base::Int : Base::Float);
  if (isScalar(a)) return b;
  if (isScalar(b)) return a;
  const auto isOffset = [](Base x) { return x == Base::Vector || x == Base::Normal; };
  if (op == Punct::Minus && a.base == Base::Point && b.base == Base::Point) return plain(Base::Vector);
  if ((op == Punct::Plus || op == Punct::Minus) && a.base == Base::Point && isOffset(b.base)) return a;
  if (op == Punct::Plus && isOffset(a.base) && b.base == Base::Point) return b;
  return a;
}

Type Checker::binary(Expr* e, Type expected) {
  const Type a = check(e->a, expected), b = check(e->b, expected);
  if (isPoison(a) || isPoison(b)) return kPoison;
  Expr* operands[] = {e->a, e->b};
  if (e->op != Punct::AndAnd && e->op != Punct::OrOr)
    if (Function* f = operatorFor(e, operands, expected)) return f->type;
  const Type t = binaryType(e->op, a, b);
  if (t.base != Base::Void) {
    if (uses_) use(text(a) + " " + std::string(spelling(e->op)) + " " + text(b));
    return t;
  }
  if (a == Type{} || b == Type{})
    error(a == Type{} ? e->a->pos : e->b->pos, "this has no value");
  else
    error(e->pos, "operator " + std::string(spelling(e->op)) + " takes no '" + text(a) + "' and '" + text(b) + "'");
  return kPoison;
}

bool Checker::writable(Expr* e) {
  switch (e->kind) {
    case ExprKind::Index:
    case ExprKind::Field:
      return writable(e->a);
    case ExprKind::Variable:
      break;
    default:
      error(e->pos, "this cannot be written to");
      return false;
  }
  Var* v = e->var;
  if (!v) return false;
  const std::string name = "'" + text(v->name) + "'";
  switch (v->kind) {
    case VarKind::Parameter:
      error(e->pos, "parameter " + name + " cannot be written to: it is no output");
      return false;
    case VarKind::Argument:
      if (!v->isWritten)
        messages_.warning(e->pos, "parameter " + name + " is no output: the caller's value stays as it is");
      break;
    case VarKind::Global:
      if (hasShader_ && !isWritable(v->globalIndex, kind_))
        messages_.warning(e->pos, "shaders of this kind should not write " + name);
      break;
    default:
      break;
  }
  v->isWritten = true;
  return true;
}

Type Checker::assign(Expr* e) {
  const Type t = check(e->a);
  if (e->op == Punct::Assign) {
    const Type from = checkAs(e->b, isPoison(t) ? kPoison : t, "assign");
    if (isPoison(t) || isPoison(from) || !writable(e->a)) return kPoison;
    if (uses_) use(text(t) + " = " + text(from));
    return t;
  }
  // a op= b: lowered from the operation that c stands for, its left side evaluated once
  Expr* operation = pool_.make<Expr>();
  operation->kind = ExprKind::Binary;
  operation->pos = e->pos;
  operation->op = withoutAssign(e->op);
  operation->a = e->a;
  operation->b = e->b;
  e->c = operation;
  if (isPoison(t)) {
    if (e->b->kind != ExprKind::List) check(e->b);
    return kPoison;
  }
  const Type b = check(e->b, t);
  if (isPoison(b)) return kPoison;
  Expr* operands[] = {e->a, e->b};
  if (Function* f = operatorFor(operation, operands, t))
    operation->type = f->type;
  else
    operation->type = binaryType(operation->op, t, b);
  if (uses_ && !operation->function) use(text(t) + " " + std::string(spelling(operation->op)) + "= " + text(b));
  if (operation->type.base == Base::Void) {
    error(e->pos,
          "operator " + std::string(spelling(operation->op)) + "= takes no '" + text(t) + "' and '" + text(b) + "'");
    return kPoison;
  }
  if (!assignable(t, operation->type)) {
    if (!(isInt(t) && isScalar(operation->type))) {
      error(e->pos, "cannot assign '" + text(operation->type) + "' to '" + text(t) + "'");
      return kPoison;
    }
    messages_.warning(e->pos, "assignment may lose precision: int = float");
  }
  return writable(e->a) ? t : kPoison;
}

Type Checker::increment(Expr* e) {
  const Type t = check(e->a);
  if (isPoison(t)) return kPoison;
  if (!isScalar(t)) {
    error(e->pos,
          std::string("operator ") + (e->op == Punct::Increment ? "++" : "--") + " takes no '" + text(t) + "'");
    return kPoison;
  }
  if (uses_) use((e->op == Punct::Increment ? "++ " : "-- ") + text(t));
  return writable(e->a) ? t : kPoison;
}

Type Checker::ternary(Expr* e, Type expected) {
  Type c = check(e->a, plain(Base::Int));
  if (!isPoison(c) && !isCondition(c)) {
    error(e->a->pos, "a value of type '" + text(c) + "' is no condition");
    c = kPoison;
  }
  Type a, b;
  // a list takes its type from the other side, or from what is expected
  if (e->b->kind == ExprKind::List && e->c->kind != ExprKind::List && expected.base == Base::Void) {
    b = check(e->c, expected);
    a = check(e->b, b);
  } else {
    a = check(e->b, expected);
    b = check(e->c, e->c->kind == ExprKind::List && expected.base == Base::Void ? a : expected);
  }
  if (isPoison(a) || isPoison(b) || isPoison(c)) return kPoison;
  if (uses_) use("? " + text(a) + " : " + text(b));
  if (a == b && a != Type{}) return a;
  if (isScalar(a) && isScalar(b)) return plain(Base::Float);
  if (isTripleValue(a) && (isTripleValue(b) || isScalar(b))) return a;
  if (isScalar(a) && (isTripleValue(b) || isMatrix(b))) return b;
  if (isMatrix(a) && isScalar(b)) return a;
  error(e->pos, "'? :' cannot choose between '" + text(a) + "' and '" + text(b) + "'");
  return kPoison;
}

Type Checker::cast(Expr* e) {
  const Type to = resolve(e->spec, false);
  const Type from = check(e->a, to);
  if (isPoison(to) || isPoison(from)) return kPoison;
  if (uses_) use("(" + text(to) + ") " + text(from));
  if (assignable(to, from) || (isInt(to) && isScalar(from))) return to;
  error(e->pos, "'" + text(from) + "' cannot be cast to '" + text(to) + "'");
  return kPoison;
}

// reference: osl-numerics, section 11: the forms each type's constructor has
Type Checker::construct(Expr* e) {
  const Type to = plain(e->spec.base);
  std::vector<Type> types;
  const bool isOne = e->list.size() == 1;
  bool isGood = true;
  for (Expr* x : e->list) {
    types.push_back(check(x, isOne && isTriple(to.base) ? to : x->kind == ExprKind::List ? to : plain(Base::Float)));
    isGood &= !isPoison(types.back());
  }
  if (!isGood) return kPoison;
  const size_t n = types.size();
  const auto scalars = [&](size_t from) {
    for (size_t i = from; i < n; ++i)
      if (!isScalar(types[i])) return false;
    return true;
  };
  const bool hasSpace = n > 0 && types[0] == plain(Base::String);
  if (uses_) {
    std::string given;
    for (const Type& t : types) given += (given.empty() ? "" : ", ") + text(t);
    use(text(to) + " from (" + given + ")");
  }
  switch (to.base) {
    case Base::Int:
    case Base::Float:
      if (n == 1 && scalars(0)) return to;
      break;
    case Base::Matrix:
      if ((n == 1 || n == 16) && scalars(0)) return to;
      if (n == 1 && isMatrix(types[0])) return to;
      if (hasSpace && (n == 2 || n == 17) && scalars(1)) return to;
      if (hasSpace && n == 2 && types[1] == plain(Base::String)) return to;
      break;
    case Base::Closure:
      break;
    default:
      if (!isTriple(to.base)) break;
      if (n == 1 && (isScalar(types[0]) || isTripleValue(types[0]))) return to;
      if (n == 3 && scalars(0)) return to;
      if (n == 4 && hasSpace && scalars(1)) return to;
      // a space and one number for all three
      break;
  }
  std::string given;
  for (const Type& t : types) given += (given.empty() ? "" : ", ") + text(t);
  error(e->pos, "no '" + text(to) + "' can be made from (" + given + ")");
  return kPoison;
}

}  // namespace kinora::language::front
