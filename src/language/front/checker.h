// Gives every expression its type and every name its meaning, and refuses what the language refuses. A wrong
// expression gets the type kPoison, about which nothing more is said: one mistake is one message. Called by
// compile().
#pragma once
#include <string>
#include <vector>

#include "language/front/ast.h"
#include "language/front/builtins.h"

namespace kinora::language::front {

class Checker {
 public:
  Checker(Pool& pool, Names& names, Messages& messages, std::vector<std::string>* uses = nullptr)
      : pool_(pool), names_(names), messages_(messages), uses_(uses) {}
  ShaderDecl* run(const Program& program);  // null when the program has none
  std::vector<Structure> takeStructures() { return std::move(structures_); }

 private:
  struct Body {                    // what is being checked
    Function* function = nullptr;  // null: a shader
    Body* outer = nullptr;
    uint32_t loops = 0;
    bool hasReturn = false;
  };
  struct Candidate {
    Function* function = nullptr;
    const Builtin* builtin = nullptr;
    const Signature* signature = nullptr;  // of a builtin
    int score = 0, resultScore = 0;
  };

  // checker.cpp: declarations and statements
  Type resolve(const TypeSpec& spec, bool mayBeUnsized);
  Type parameterType(const Var* p);
  void declare(StructDecl* s);
  void declare(Function* f);
  void declare(Var* v);
  void body(Function* f);
  void shader(ShaderDecl* s);
  void initialise(Var* v);
  void metadata(std::span<MetaDecl> list);
  void loadPrelude(Name name);
  void warnOfLibrary(Function* f);
  void statement(Stmt* s);
  void condition(Expr* e);
  static bool alwaysReturns(const Stmt* s);
  void push() { marks_.push_back(undo_.size()); }
  void pop();
  Var* find(Name name);

  // check_expression.cpp
  Type check(Expr* e, Type expected = {});
  Type checkAs(Expr* e, Type target, const char* what);  // converted to target: initialisers, assignments
  Type list(Expr* e, Type target);
  Type variable(Expr* e);
  Type index(Expr* e);
  Type indexOf(Expr* e, Type indexed);
  Type field(Expr* e);
  Type unary(Expr* e, Type expected);
  Type binary(Expr* e, Type expected);
  Type binaryType(Punct op, const Type& a, const Type& b) const;
  Type assign(Expr* e);
  Type increment(Expr* e);
  Type ternary(Expr* e, Type expected);
  Type cast(Expr* e);
  Type construct(Expr* e);
  bool writable(Expr* e);  // reports why not

  // check_call.cpp
  Type call(Expr* e, Type expected);
  bool checkElements(Expr* list);
  bool isHiddenByVariable(Name name);
  Type structConstruct(Expr* e, int32_t structure);
  Function* operatorFor(Expr* e, std::span<Expr*> operands, Type expected);
  bool match(Candidate& c, std::span<Expr*> arguments, Type expected);
  int scoreOf(const Type& formal, Expr* argument);
  bool fits(Expr* list, const Type& type) const;
  void bind(Expr* e, const Candidate& c, std::span<Expr*> arguments);
  void special(Expr* e);
  void format(Expr* e, size_t at);
  std::string signatureText(const Candidate& c) const;

  std::string text(const Type& type) const;
  std::string text(Name name) const { return std::string(names_.text(name)); }
  void use(const std::string& what) const {
    if (uses_ && !isInPrelude_) uses_->push_back(what);
  }
  void error(Pos pos, std::string what) { messages_.error(pos, std::move(what)); }

  struct StructInfo {
    Name name;
    Pos pos;
    std::vector<Name> fields;
    bool hasArray = false;
    size_t leaves = 0;  // values when structs inside are taken apart
  };
  enum class Space : uint8_t { Vars, Functions, Structs };
  struct Undo {
    Space space;
    Name name;
    void* before;
    uint32_t scopeBefore;
  };
  template <class T>
  struct Table {
    std::vector<T> of;
    T& operator[](Name n) {
      if (n >= of.size()) of.resize(n + 64);
      return of[n];
    }
  };

  Pool& pool_;
  Names& names_;
  Messages& messages_;
  std::vector<std::string>* uses_;
  std::vector<Structure> structures_;
  std::vector<StructInfo> infos_;
  struct VarEntry {
    Var* var = nullptr;
    uint32_t scope = 0;
  };
  Table<VarEntry> vars_;
  Table<Function*> functions_;
  Table<Function*> prelude_;
  Table<int32_t> structs_;  // index + 1
  Table<uint8_t> preludeSeen_;
  std::vector<Undo> undo_;
  std::vector<size_t> marks_;
  std::array<Var*, 16> globals_{};
  uint32_t scopes_ = 0, preludeScope_ = 0;
  std::vector<uint32_t> scopeStack_ = {0};
  std::vector<Function*> checking_;
  Body* body_ = nullptr;
  ShaderKind kind_ = ShaderKind::Shader;
  bool hasShader_ = false, isInPrelude_ = false;
};

constexpr uint32_t kGlobalNg = 3;
// Globals, by their index (Var::globalIndex): whether shaders of a kind have them and may write them.
bool isReadable(uint32_t global, ShaderKind kind);
bool isWritable(uint32_t global, ShaderKind kind);

}  // namespace kinora::language::front
