// The text that others read: layout of symbols, hints and jumps.
#include "language/program/oso_writer.h"

#include <gtest/gtest.h>

#include "language/front/test_support.h"

namespace kinora::language {
namespace {

std::string osoOf(const std::string& source) {
  const Compiled c = compiled(source);
  EXPECT_TRUE(c.result.ok()) << c.errors;
  return c.result.ok() ? osoText(*c.result.shader) : "";
}

TEST(OsoWriter, AWholeShader) {
  EXPECT_EQ(osoOf("surface small [[ string help = \"a \\\"b\\\"\" ]]\n"
                  "(float Kd = 0.5 [[ float min = 0, string label = \"K\" ]], output color result = Kd)\n"
                  "{\n"
                  "  if (Kd > 0.25)\n"
                  "    result *= 2;\n"
                  "}\n"),
            "OpenShadingLanguage 1.00\n"
            "# Compiled by kinora\n"
            "surface small\t%meta{string,help,\"a \\\"b\\\"\"} \n"
            "param\tfloat\tKd\t0.5 \t%meta{float,min,0} %meta{string,label,\"K\"} %read{0,1} %write{2147483647,-1}\n"
            "oparam\tcolor\tresult\t0 0 0 \t%read{3,3} %write{0,3} %initexpr\n"
            "const\tfloat\t$const0\t0.25 \t%read{1,1} %write{2147483647,-1}\n"
            "temp\tint\t$tmp0\t\t%read{2,2} %write{1,1}\n"
            "const\tfloat\t$const2\t2 \t%read{3,3} %write{2147483647,-1}\n"
            "code result\n"
            "\tassign\t\tresult Kd \t%filename{\"t.osl\"} %line{2} %argrw{\"wr\"}\n"
            "code ___main___\n"
            "\tgt\t\t$tmp0 Kd $const0 \t%line{4} %argrw{\"wrr\"}\n"
            "\tif\t\t$tmp0 4 4 \t%argrw{\"r\"}\n"
            "\tmul\t\tresult result $const2 \t%line{5} %argrw{\"wrr\"}\n"
            "\tend\n");
}

TEST(OsoWriter, JumpsOfLoopsAndCalls) {
  const std::string s = osoOf(
      "float g(float x) { if (x > 1) return 1; return x; }\n"
      "shader t(output float r = 0) { for (int i = 0; i < 3; ++i) r += g(r); while (r > 1) r -= 1; }");
  // 0 for, 1 init, 2 condition, 3.. body with the call at 3: gt, if, assign, return, assign; add; step
  EXPECT_NE(s.find("\tfor\t\t$tmp0 2 3 10 11 "), std::string::npos) << s;
  EXPECT_NE(s.find("\tfunctioncall\t\t$const"), std::string::npos) << s;
  EXPECT_NE(s.find(" 9 \t%argrw{\"r\"}"), std::string::npos) << s;
  EXPECT_NE(s.find("\twhile\t\t$tmp"), std::string::npos) << s;
}

TEST(OsoWriter, StructsAndArrays) {
  const std::string s = osoOf(
      "struct In { float x; }; struct S { float a; color c[2]; In in; };\n"
      "shader t(S s = {1, {2, 3}, {4}}, string n[2] = {\"a\\n\", \"b\"}, int k[] = {1, 2}, closure color c = 0) { }");
  EXPECT_NE(s.find("param\tstruct S\ts\t\t%read{2147483647,-1} %write{2147483647,-1} %struct{\"S\"} "
                   "%structfields{a,c,in} %structfieldtypes{\"fc[2]SIn\"} %structnfields{3}\n"),
            std::string::npos)
      << s;
  EXPECT_NE(s.find("param\tcolor[2]\ts.c\t2 2 2 3 3 3 \t"), std::string::npos) << s;
  EXPECT_NE(s.find("%mystruct{s.in} %mystructfield{0}"), std::string::npos) << s;
  EXPECT_NE(s.find("param\tstring[2]\tn\t\"a\\n\" \"b\" \t"), std::string::npos) << s;
  EXPECT_NE(s.find("param\tint[]\tk\t1 2 \t"), std::string::npos) << s;
  EXPECT_NE(s.find("param\tclosure color\tc\t\t"), std::string::npos) << s;
}

}  // namespace
}  // namespace kinora::language
