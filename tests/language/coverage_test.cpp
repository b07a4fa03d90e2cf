// The programs of tests/language/programs use everything that the language has: every overload of every library
// function, every operator on every pair of types that it takes. What there is, is asked of the compiler: its tables
// of functions, and one tiny shader for each operator and each choice of types. A new function without a program
// fails here.
#include <gtest/gtest.h>

#include <algorithm>
#include <regex>
#include <set>

#include "language/front/builtins.h"
#include "language/front/compile.h"
#include "language/front/prelude.h"
#include "language/program_file.h"

namespace kinora::oracle {
namespace {

using namespace language;

using Uses = std::set<std::string>;

// As the compiler names an overload.
std::string signatureName(const front::Builtin& b, const front::Signature& s) {
  std::string formals;
  for (uint32_t i = 0; i < s.count; ++i)
    formals += (i ? ", " : "") + std::string(s.formals[i].isOutput ? "output " : "") +
               (s.formals[i].isAny ? "any" : nameOf(s.formals[i].type));
  if (s.rest) formals += formals.empty() ? "..." : ", ...";
  return nameOf(s.result) + " " + std::string(b.name) + " (" + formals + ")";
}

Uses libraryFunctions() {
  Uses all;
  for (const front::Builtin& b : front::allBuiltins())
    for (const front::Signature& s : front::signaturesOf(b)) all.insert(signatureName(b, s));
  // "TYPE NAME(TYPE a, output TYPE b) {" begins a function of the prelude
  static const std::regex kHead("(^|\n)([a-z][a-z ]*) (\\w+)\\(([^)]*)\\) \\{"), kName(" \\w+(,|$)");
  for (const std::string_view name : front::preludeFunctionNames()) {
    const std::string text(front::preludeFunction(name));
    for (std::sregex_iterator m(text.begin(), text.end(), kHead), end; m != end; ++m)
      all.insert((*m)[2].str() + " " + (*m)[3].str() + " (" + std::regex_replace((*m)[4].str(), kName, "$1") + ")");
  }
  return all;
}

// What a shader of one statement uses; nothing where the compiler refuses it.
Uses usesOf(const std::string& statement) {
  std::vector<std::string> uses;
  CompileOptions options;
  options.uses = &uses;
  options.withWarnings = false;
  const CompileResult r = compile("shader t(output float out = 0) {\n" + statement + "\n}\n", "t.osl", options);
  return r.ok() ? Uses(uses.begin(), uses.end()) : Uses();
}

Uses operators() {
  static const char* const kTypes[] = {"int",    "float",  "string", "color",        "point",
                                       "vector", "normal", "matrix", "closure color"};
  Uses all;
  const auto add = [&](const std::string& statement) { all.merge(usesOf(statement)); };
  for (const std::string a : kTypes) {
    const std::string x = a + " x; ";
    for (const char* op : {"-x", "!x", "~x", "++x", "--x"}) add(x + op + ";");
    for (const char* rest : {"x[0];", "x.x;", "x.y;", "x.z;", "x.r;", "x.g;", "x.b;"}) add(x + rest);
    add(a + " x[2]; x[0];");
    add("matrix m; m[0][1];");
    for (const char* space : {"", "\"object\", "})
      for (const char* values :
           {"1", "1.0", "1, 2, 3", "1.0, 2.0, 3.0", "1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16",
            "1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0, 14.0, 15.0, 16.0", "\"shader\""})
        if (a != "closure color") add(a + "(" + space + values + ");");
    for (const std::string b : kTypes) {
      const std::string xy = x + b + " y; ";
      for (const char* op :
           {"+", "-", "*", "/", "%", "<<", ">>", "&", "|", "^", "&&", "||", "==", "!=", "<", "<=", ">", ">="})
        add(xy + "x " + op + " y;");
      for (const char* op : {"=", "+=", "-=", "*=", "/=", "<<=", ">>=", "&=", "|=", "^="})
        add(xy + "x " + op + " y;");
      add(xy + "u > 0 ? x : y;");
      add(b + " y; (" + a + ") y;");
      if (a != "closure color") add(b + " y; " + a + "(y);");
    }
  }
  return all;
}

TEST(Programs, UseEveryFunctionAndOperator) {
  Uses used;
  for (const ProgramFile& p : readPrograms()) used.insert(p.uses.begin(), p.uses.end());
  const Uses functions = libraryFunctions(), ops = operators();
  // both would shrink unnoticed if the compiler stopped telling
  EXPECT_GE(functions.size(), 500u);
  EXPECT_GE(ops.size(), 400u);
  std::string missing;
  size_t count = 0;
  for (const Uses* all : {&functions, &ops})
    for (const std::string& f : *all)
      if (!used.contains(f)) missing += f + "\n", ++count;
  EXPECT_EQ(missing, "") << count << " of " << functions.size() << " overloads and " << ops.size()
                         << " operators are used by no program";
  RecordProperty("overloads", int(functions.size()));
  RecordProperty("operators", int(ops.size()));
}

}  // namespace
}  // namespace kinora::oracle
