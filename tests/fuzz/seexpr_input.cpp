#include "fuzz/seexpr_input.h"

#include <cctype>
#include <cstdio>
#include <cstdlib>

#include "fuzz/oso_input.h"
#include "language/front/compile.h"
#include "language/program/oso_writer.h"
#include "language/seexpr/translate.h"

namespace kinora::fuzz {

namespace {

[[noreturn]] void fail(const char* what, std::string_view expression, const std::string& why) {
  std::fprintf(stderr, "%s: %s\n%.*s\n", what, why.c_str(), int(expression.size()), expression.data());
  std::abort();
}

}  // namespace

size_t runSeExprInput(std::string_view expression) {
  using namespace kinora::language;
  // names like functions and variables of the renderer's among them, as exporters choose them
  static const std::vector<seexpr::Input> kInputs = {{"colorInput1", true},  {"colorInput2", true},
                                                     {"floatInput1", false}, {"a", true},
                                                     {"noise", false},       {"u", true}};
  const seexpr::Translation t = seexpr::translate(expression, kInputs, "e");
  if (t.source.empty() == t.problem.empty()) fail("neither refused nor translated", expression, t.problem);
  if (t.source.empty()) {
    if (!std::isdigit(static_cast<unsigned char>(t.problem[0])))
      fail("refused without a place", expression, t.problem);
    return 1;
  }
  const CompileResult result = compile(t.source, "e.osl");
  if (!result.ok()) fail("does not compile", expression, result.messages[0].str());
  runOsoInput(osoText(*result.shader));
  return 0;
}

}  // namespace kinora::fuzz
