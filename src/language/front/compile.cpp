#include "language/front/compile.h"

#include "language/front/checker.h"
#include "language/front/lower.h"
#include "language/front/parser.h"
#include "language/front/preprocessor.h"

namespace kinora::language {

namespace front {
namespace {

// Keywords are the first names of every compilation.
void internKeywords(Names& names) {
  for (const char* word : {
#define KN_X(word) #word,
           KN_LANGUAGE_KEYWORDS(KN_X)
#undef KN_X
       })
    names.intern(word);
}

void run(std::string_view source, const std::string& name, const CompileOptions& options, const FileReader& reader,
         Messages& messages, CompileResult& result) {
  Pool pool;
  Names names(pool);
  internKeywords(names);
  Preprocessor preprocessor(options, reader, pool, names, messages);
  std::vector<Token> tokens;
  try {
    tokens = preprocessor.run(name, source);
  } catch (const Stop&) {
    result.files = preprocessor.filesRead();
    throw;
  }
  result.files = preprocessor.filesRead();
  if (messages.hasErrors()) return;  // a missing include alone would make a hundred names unknown
  const Program program = Parser(tokens, pool, names, messages).run();
  if (messages.hasErrors()) return;  // what was skipped would be missed
  Checker checker(pool, names, messages, options.uses);
  ShaderDecl* shader = checker.run(program);
  if (!shader && !messages.hasErrors()) messages.error({1, 0, 0}, "there is no shader in \"" + name + "\"");
  if (messages.hasErrors()) return;
  result.shader = Lowerer(checker.takeStructures(), names, messages).run(shader);
}

}  // namespace
}  // namespace front

CompileResult compile(std::string_view source, const std::string& name, const CompileOptions& options,
                      const FileReader& reader) {
  CompileResult result;
  front::Messages messages(options);
  try {
    front::run(source, name, options, reader, messages, result);
  } catch (const front::Stop&) {
  }
  if (messages.hasErrors()) result.shader.reset();
  result.messages = messages.take();
  return result;
}

PreprocessResult preprocess(std::string_view source, const std::string& name, const CompileOptions& options,
                            const FileReader& reader) {
  PreprocessResult result;
  front::Messages messages(options);
  front::Pool pool;
  front::Names names(pool);
  front::internKeywords(names);
  front::Preprocessor preprocessor(options, reader, pool, names, messages);
  try {
    result.text = front::textOf(preprocessor.run(name, source), messages);
  } catch (const front::Stop&) {
  }
  result.files = preprocessor.filesRead();
  result.isOk = !messages.hasErrors();
  result.messages = messages.take();
  return result;
}

}  // namespace kinora::language
