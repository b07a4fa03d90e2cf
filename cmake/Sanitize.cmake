# Address and undefined-behaviour sanitizers. ON watches every file. HOST leaves out kernels, which write into arenas that
# a sanitizer takes for one block, and tests: it builds and runs the whole test set in a few times the plain time, where ON
# takes hours on two cores.
set(KINORA_SANITIZERS -fsanitize=address,undefined -fno-omit-frame-pointer -fno-sanitize-recover=undefined)
if(KINORA_SANITIZE)
  add_link_options(-fsanitize=address,undefined)
  add_compile_definitions(KINORA_SANITIZED)  # also where the file itself is not watched
  if(NOT KINORA_SANITIZE STREQUAL "HOST")
    add_compile_options(${KINORA_SANITIZERS})
  endif()
endif()

# Of sources of the renderer and of plug-ins.
function(kinora_sanitize)
  if(KINORA_SANITIZE STREQUAL "HOST")
    foreach(source ${ARGN})
      file(STRINGS ${source} kernel REGEX "foreach_target|KINORA_KERNEL_FILE" LIMIT_COUNT 1)
      if(NOT kernel)
        set_property(SOURCE ${source} APPEND PROPERTY COMPILE_OPTIONS -O1 ${KINORA_SANITIZERS})
        # headers precompiled with other options would be refused, file by file
        set_property(SOURCE ${source} PROPERTY SKIP_PRECOMPILE_HEADERS ON)
      endif()
    endforeach()
  endif()
endfunction()
