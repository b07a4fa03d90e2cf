// Declarations and statements; check_expression.cpp and check_call.cpp have the rest.
#include "language/front/checker.h"

#include <algorithm>

#include "language/front/constants.h"
#include "language/front/lexer.h"
#include "language/front/parser.h"
#include "language/front/prelude.h"

namespace kinora::language::front {

namespace {

enum : uint8_t { kSurface = 1, kDisplacement = 2, kVolume = 4, kAll = 7 };
struct Global {
  std::string_view name;
  Base base;
  uint8_t readable, writable;
};
// reference: osl, section 4. A generic shader may read all, and write what shaders of some kind may
constexpr Global kGlobals[] = {
    {"P", Base::Point, kAll, kDisplacement},
    {"I", Base::Vector, kSurface | kVolume, 0},
    {"N", Base::Normal, kSurface | kDisplacement, kSurface | kDisplacement},
    {"Ng", Base::Normal, kSurface | kDisplacement, 0},
    {"dPdu", Base::Vector, kSurface | kDisplacement, 0},
    {"dPdv", Base::Vector, kSurface | kDisplacement, 0},
    {"Ps", Base::Point, kAll, 0},
    {"u", Base::Float, kAll, 0},
    {"v", Base::Float, kAll, 0},
    {"time", Base::Float, kAll, 0},
    {"dtime", Base::Float, kAll, 0},
    {"dPdtime", Base::Vector, kAll, 0},
    {"Ci", Base::Closure, kSurface | kVolume, kSurface | kVolume},
};
static_assert(kGlobals[kGlobalNg].name == "Ng");
uint8_t bitOf(ShaderKind kind) {
  return kind == ShaderKind::Surface        ? kSurface
         : kind == ShaderKind::Displacement ? kDisplacement
         : kind == ShaderKind::Volume       ? kVolume
                                            : 0;
}

}  // namespace

bool isReadable(uint32_t global, ShaderKind kind) {
  return kind == ShaderKind::Shader || (kGlobals[global].readable & bitOf(kind));
}
bool isWritable(uint32_t global, ShaderKind kind) {
  const uint8_t writable = kGlobals[global].writable;
  return kind == ShaderKind::Shader ? writable != 0 : writable & bitOf(kind);
}

std::string Checker::text(const Type& type) const {
  if (isPoison(type)) return "?";
  if (type.base != Base::Struct) return nameOf(type);
  std::string s = type.structure >= 0 ? text(infos_[size_t(type.structure)].name) : "struct";
  if (type.arrayLength < 0) s += "[]";
  if (type.arrayLength > 0) s += "[" + std::to_string(type.arrayLength) + "]";
  return s;
}

void Checker::pop() {
  while (undo_.size() > marks_.back()) {
    const Undo u = undo_.back();
    undo_.pop_back();
    switch (u.space) {
      case Space::Vars:
        vars_[u.name] = {static_cast<Var*>(u.before), u.scopeBefore};
        break;
      case Space::Functions:
        functions_[u.name] = static_cast<Function*>(u.before);
        break;
      case Space::Structs:
        structs_[u.name] = int32_t(u.scopeBefore);
        break;
    }
  }
  marks_.pop_back();
}

Type Checker::resolve(const TypeSpec& spec, bool mayBeUnsized) {
  Type t;
  t.base = spec.base;
  if (spec.base == Base::Struct) {
    const int32_t id = structs_[spec.structName];
    if (id == 0) {
      error(spec.pos, "there is no type '" + text(spec.structName) + "'");
      return kPoison;
    }
    t.structure = id - 1;
  }
  if (spec.isUnsized) {
    t.arrayLength = -1;
    if (!mayBeUnsized) {
      error(spec.pos, "the array needs a length");
      return kPoison;
    }
  }
  if (spec.length) {
    const Type length = check(spec.length);
    Values v;
    if (isPoison(length)) return kPoison;
    if (length != Type{Base::Int, 0, -1} || !constantOf(*spec.length, v)) {
      error(spec.length->pos, "the length of an array must be a constant int");
      return kPoison;
    }
    if (v.ints[0] < 1 || v.ints[0] > kMostElements) {
      error(spec.length->pos,
            "arrays have 1 to " + std::to_string(kMostElements) + " elements, not " + std::to_string(v.ints[0]));
      return kPoison;
    }
    t.arrayLength = v.ints[0];
  }
  if (t.arrayLength != 0 && t.base == Base::Struct && infos_[size_t(t.structure)].hasArray) {
    error(spec.pos, "arrays of '" + text(spec.structName) + "' are not supported: it holds an array");
    return kPoison;
  }
  if (t.arrayLength != 0 && t.base == Base::Void) {
    error(spec.pos, "there are no arrays of void");
    return kPoison;
  }
  return t;
}

void Checker::declare(StructDecl* s) {
  const int32_t old = structs_[s->name];
  if (old != 0) return error(s->pos, "struct '" + text(s->name) + "' is declared already");
  StructInfo info{s->name, s->pos, {}, false};
  Structure structure;
  structure.name = text(s->name);
  for (Var* f : s->fields) {
    f->type = resolve(f->spec, false);
    if (!isPoison(f->type) && f->type.base == Base::Void) {
      error(f->pos, "a field cannot be void");
      f->type = kPoison;
    }
    if (std::find(info.fields.begin(), info.fields.end(), f->name) != info.fields.end())
      error(f->pos, "field '" + text(f->name) + "' is declared already");
    info.fields.push_back(f->name);
    info.hasArray |=
        f->type.arrayLength != 0 || (f->type.base == Base::Struct && infos_[size_t(f->type.structure)].hasArray);
    structure.fields.push_back({text(f->name), f->type});
  }
  if (s->fields.empty()) error(s->pos, "struct '" + text(s->name) + "' has no fields");
  // flattened later: a struct of structs of structs must not explode
  size_t leaves = 0;
  for (const Field& f : structure.fields) {
    if (f.type.base != Base::Struct || isPoison(f.type))
      ++leaves;
    else
      leaves += infos_[size_t(f.type.structure)].leaves;
  }
  info.leaves = leaves;
  if (leaves > 4096) error(s->pos, "struct '" + text(s->name) + "' holds too many values");
  undo_.push_back({Space::Structs, s->name, nullptr, uint32_t(old)});
  infos_.push_back(std::move(info));
  structures_.push_back(std::move(structure));
  structs_[s->name] = leaves > 4096 ? 0 : int32_t(infos_.size());
}

void Checker::declare(Var* v) {
  VarEntry& entry = vars_[v->name];
  const uint32_t scope = scopeStack_.back();
  if (entry.var && entry.scope == scope && scope != 0) {
    error(v->pos, "'" + text(v->name) + "' is declared already in this scope, in line " +
                      std::to_string(entry.var->pos.line));
  }
  if (!isInPrelude_ && names_.text(v->name).starts_with("___"))
    error(v->pos, "names that begin with \"___\" are reserved");
  undo_.push_back({Space::Vars, v->name, entry.var, entry.scope});
  entry = {v, scope};
}

Var* Checker::find(Name name) {
  // the library's own functions see nothing of the shader but its globals
  const VarEntry& entry = vars_[name];
  if (entry.var && (!isInPrelude_ || entry.scope > preludeScope_)) return entry.var;
  const std::string_view t = names_.text(name);
  for (size_t i = 0; i < std::size(kGlobals); ++i) {
    if (kGlobals[i].name != t) continue;
    Var*& v = globals_[i];
    if (v) return v;
    v = pool_.make<Var>();
    v->name = name;
    v->kind = VarKind::Global;
    v->globalIndex = uint32_t(i);
    v->type = {kGlobals[i].base, 0, -1};
    return v;
  }
  return nullptr;
}

Type Checker::parameterType(const Var* p) {
  const Type type = resolve(p->spec, true);
  if (isPoison(type) || type.base != Base::Void) return type;
  error(p->pos, "a parameter cannot be void");
  return kPoison;
}

void Checker::declare(Function* f) {
  f->isPrelude = isInPrelude_;
  f->type = resolve(f->spec, false);
  if (f->type.arrayLength != 0) {
    error(f->spec.pos, "functions do not return arrays");
    f->type = kPoison;
  }
  if (!isInPrelude_ && names_.text(f->name).starts_with("___"))
    error(f->pos, "names that begin with \"___\" are reserved");
  for (Var* p : f->parameters) {
    p->kind = p->isOutput ? VarKind::OutputArgument : VarKind::Argument;
    p->type = parameterType(p);
  }
  f->scope = scopeStack_.back();
  Function*& head = isInPrelude_ ? prelude_[f->name] : functions_[f->name];
  for (Function* other = head; other && other->scope == f->scope; other = other->next) {
    if (other->parameters.size() != f->parameters.size() ||
        !std::equal(f->parameters.begin(), f->parameters.end(), other->parameters.begin(),
                    [](const Var* a, const Var* b) { return a->type == b->type; }))
      continue;
    if (!other->body && f->body && !other->isClosure) {
      other->definition = f;  // declared above, defined here
    } else if (f->body && other->type == f->type) {
      messages_.warning(f->pos, "function '" + text(f->name) + "' is declared again; the first is in line " +
                                    std::to_string(other->pos.line));
    }
    break;
  }
  if (f->body && f->scope == 0 && !isInPrelude_) warnOfLibrary(f);
  // a closure primitive of somebody's own header
  if (!f->body) f->isClosure = f->type.base == Base::Closure;
  if (!isInPrelude_) undo_.push_back({Space::Functions, f->name, head, 0});
  f->next = head;
  head = f;
  if (f->body) body(f);
}

// A function of the file that takes what one of the library's takes stands in its place.
void Checker::warnOfLibrary(Function* f) {
  loadPrelude(f->name);
  const auto warn = [&] {
    messages_.warning(f->pos, "function '" + text(f->name) + "' takes the place of the library's");
  };
  const auto isSame = [&](auto&& typeOf, size_t n) {
    if (n != f->parameters.size()) return false;
    for (size_t i = 0; i < n; ++i)
      if (f->parameters[i]->type != typeOf(i)) return false;
    return true;
  };
  for (const Function* p = prelude_[f->name]; p; p = p->next)
    if (isSame([&](size_t i) { return p->parameters[i]->type; }, p->parameters.size())) return warn();
  const Builtin* b = builtinNamed(names_.text(f->name));
  if (!b) return;
  for (const Signature& s : signaturesOf(*b)) {
    const size_t n = s.rest == '+' ? std::max<size_t>(s.count, f->parameters.size()) : s.count;
    const bool isOpen = s.rest == '*' || s.rest == '@';
    if (!isOpen && isSame([&](size_t i) { return s.at(uint32_t(i)).type; }, n)) return warn();
  }
}

bool Checker::alwaysReturns(const Stmt* s) {
  if (!s) return false;
  switch (s->kind) {
    case StmtKind::Return:
      return true;
    case StmtKind::If:
      return s->other && alwaysReturns(s->body) && alwaysReturns(s->other);
    case StmtKind::Block:
      return std::any_of(s->list.begin(), s->list.end(), [](const Stmt* x) { return alwaysReturns(x); });
    case StmtKind::DoWhile:
      return alwaysReturns(s->body);
    default:
      return false;
  }
}

void Checker::body(Function* f) {
  Body mine{f, body_, 0, false};
  body_ = &mine;
  checking_.push_back(f);
  push();
  scopeStack_.push_back(++scopes_);
  for (Var* p : f->parameters) declare(p);
  for (Stmt* s : f->body->list) statement(s);
  scopeStack_.pop_back();
  pop();
  checking_.pop_back();
  body_ = mine.outer;
  if (f->type.base == Base::Void || isPoison(f->type)) return;
  if (!mine.hasReturn)
    error(f->pos, "function '" + text(f->name) + "' returns no value");
  else if (!alwaysReturns(f->body))
    messages_.warning(f->pos, "function '" + text(f->name) + "' may end without 'return'");
}

void Checker::metadata(std::span<MetaDecl> list) {
  for (MetaDecl& m : list) {
    const Type t = resolve(m.spec, true);
    if (isPoison(t)) continue;
    if (componentsOf(t.base) == 0) {
      error(m.pos, "metadata cannot be of type '" + text(t) + "'");
      continue;
    }
    Values v;
    if (!isPoison(checkAs(m.value, t, "metadata")) && !constantOf(*m.value, v))
      error(m.value->pos, "the value of metadata '" + text(m.name) + "' must be constant");
  }
}

void Checker::initialise(Var* v) {
  if (!v->init || isPoison(v->type)) {
    if (v->init) check(v->init);
    return;
  }
  // an array that has as many elements as it is given, and one of zeros otherwise
  if (v->kind == VarKind::Parameter && v->type.arrayLength < 0 && componentsOf(v->type.base) != 0 &&
      v->init->kind == ExprKind::List && v->init->list.empty()) {
    v->init->type = v->type;
    return;
  }
  const Type t = checkAs(v->init, v->type, "initialise");
  if (v->type.arrayLength < 0 && v->kind == VarKind::Local && !isPoison(t)) v->type.arrayLength = t.arrayLength;
}

void Checker::shader(ShaderDecl* s) {
  Body mine;
  body_ = &mine;
  push();
  scopeStack_.push_back(++scopes_);
  metadata(s->metadata);
  for (Var* p : s->parameters) {
    p->kind = p->isOutput ? VarKind::OutputParameter : VarKind::Parameter;
    p->type = parameterType(p);
    if (p->isOutput && p->type.arrayLength < 0) {
      error(p->pos, "output '" + text(p->name) + "' needs a length: nothing gives it one");
      p->type = kPoison;
      p->init = p->init && p->init->kind == ExprKind::List ? nullptr : p->init;
    } else if (!p->init)
      error(p->pos, "parameter '" + text(p->name) + "' has no default");
    else
      initialise(p);
    metadata(p->metadata);
    declare(p);
  }
  for (Stmt* st : s->body->list) statement(st);
  scopeStack_.pop_back();
  pop();
  body_ = nullptr;
}

void Checker::loadPrelude(Name name) {
  if (preludeSeen_[name]) return;
  preludeSeen_[name] = 1;
  const std::string_view source = preludeFunction(names_.text(name));
  if (source.empty()) return;
  const uint16_t file = messages_.addFile("<library>", std::string(source));
  Lexer lexer(messages_.text(file), file, names_, messages_);
  std::vector<Token> tokens;
  do tokens.push_back(lexer.next());
  while (tokens.back().kind != Token::Kind::End);
  const Program program = Parser(pool_.copy(tokens), pool_, names_, messages_).run();
  // checked as if it stood before everything: no name of the shader is seen
  Body* const body = body_;
  body_ = nullptr;
  const bool wasInPrelude = isInPrelude_;
  const uint32_t scope = preludeScope_;
  if (!isInPrelude_) preludeScope_ = scopes_;
  isInPrelude_ = true;
  scopeStack_.push_back(0);
  for (const Program::Item& i : program.items)
    if (i.function) declare(i.function);
  scopeStack_.pop_back();
  isInPrelude_ = wasInPrelude;
  preludeScope_ = scope;
  body_ = body;
}

ShaderDecl* Checker::run(const Program& program) {
  ShaderDecl* result = nullptr;
  for (const Program::Item& i : program.items)
    if (i.shader && !result) {
      result = i.shader;
      kind_ = result->kind;
      hasShader_ = true;
    }
  push();
  for (const Program::Item& i : program.items) {
    if (i.structure) declare(i.structure);
    if (i.function) declare(i.function);
    if (i.shader && i.shader != result)
      error(i.shader->pos, "a file holds one shader; the first is '" + text(result->name) + "'");
    if (i.shader && i.shader == result) shader(i.shader);
  }
  pop();
  return result;
}

void Checker::condition(Expr* e) {
  if (!e) return;
  const Type t = check(e);
  if (isPoison(t)) return;
  if (!isCondition(t)) error(e->pos, "a value of type '" + text(t) + "' is no condition");
}

void Checker::statement(Stmt* s) {
  switch (s->kind) {
    case StmtKind::Empty:
      break;
    case StmtKind::Expression:
      check(s->expr);
      break;
    case StmtKind::Block:
      push();
      scopeStack_.push_back(++scopes_);
      for (Stmt* x : s->list) statement(x);
      scopeStack_.pop_back();
      pop();
      break;
    case StmtKind::Variables:
      for (Var* v : s->vars) {
        v->kind = VarKind::Local;
        v->type = resolve(v->spec, v->init != nullptr);
        if (!isPoison(v->type) && v->type.base == Base::Void) {
          error(v->pos, "a variable cannot be void");
          v->type = kPoison;
        }
        initialise(v);
        declare(v);
      }
      break;
    case StmtKind::If:
      condition(s->expr);
      statement(s->body);
      if (s->other) statement(s->other);
      break;
    case StmtKind::While:
    case StmtKind::DoWhile:
    case StmtKind::For:
      push();
      scopeStack_.push_back(++scopes_);
      if (s->init) statement(s->init);
      condition(s->expr);
      if (s->step) check(s->step);
      ++body_->loops;
      statement(s->body);
      --body_->loops;
      scopeStack_.pop_back();
      pop();
      break;
    case StmtKind::Break:
    case StmtKind::Continue:
      if (body_->loops == 0)
        error(s->pos, s->kind == StmtKind::Break ? "'break' outside of a loop" : "'continue' outside of a loop");
      break;
    case StmtKind::Return: {
      body_->hasReturn = true;
      const Function* f = body_->function;
      if (!f) {
        if (s->expr) {
          check(s->expr);
          error(s->pos, "a shader returns no value");
        }
      } else if (f->type.base == Base::Void && !isPoison(f->type)) {
        if (s->expr) {
          check(s->expr);
          error(s->pos, "function '" + text(f->name) + "' is void and returns no value");
        }
      } else if (!s->expr) {
        error(s->pos, "function '" + text(f->name) + "' must return a value of type '" + text(f->type) + "'");
      } else {
        checkAs(s->expr, f->type, "return");
      }
      break;
    }
    case StmtKind::Function:
      declare(s->function);
      break;
    case StmtKind::Struct:
      declare(s->structure);
      break;
  }
}

}  // namespace kinora::language::front
