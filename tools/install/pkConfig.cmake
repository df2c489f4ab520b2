# find_package(pk): the runtime as pk::pk, and pk_add_model() for models. Their manual is
# docs/export-cmake.md of pkgen.
cmake_minimum_required(VERSION 3.20)
get_filename_component(pk_PREFIX "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)
find_program(pk_PKGEN pkgen HINTS "${pk_PREFIX}/bin" DOC "the compiler of .lag models")

if(NOT TARGET pk::pk)
  add_library(pk::pk STATIC IMPORTED)
  set_target_properties(pk::pk PROPERTIES
    IMPORTED_LOCATION "${pk_PREFIX}/lib/libpk.a"
    INTERFACE_INCLUDE_DIRECTORIES "${pk_PREFIX}/include"
    INTERFACE_COMPILE_DEFINITIONS PK_RUNTIME
    INTERFACE_LINK_LIBRARIES "$<$<NOT:$<BOOL:${WIN32}>>:m>")
endif()

# pk_add_model(TARGET MODEL.lag... [WITHOUT_RUNTIME] [OPTIONS word...])
#
# The C of models becomes part of TARGET, a library of that name where there is none yet, and is made
# again when a model changes. OPTIONS are those of `pkgen MODEL.lag`: --scene NAME, --size N=64.
function(pk_add_model target)
  cmake_parse_arguments(PARSE_ARGV 1 pk "WITHOUT_RUNTIME" "" "OPTIONS")
  if(NOT pk_PKGEN)
    message(FATAL_ERROR "pk_add_model: there is no pkgen in ${pk_PREFIX}/bin or on the PATH")
  elseif(NOT pk_UNPARSED_ARGUMENTS)
    message(FATAL_ERROR "pk_add_model(${target}): name a model, x.lag")
  endif()
  if(NOT TARGET ${target})
    add_library(${target} STATIC)
  endif()
  set(folder "${CMAKE_CURRENT_BINARY_DIR}/${target}.models")
  set(form --runtime)
  if(pk_WITHOUT_RUNTIME)
    set(form)
  endif()
  get_property(languages GLOBAL PROPERTY ENABLED_LANGUAGES)
  foreach(model IN LISTS pk_UNPARSED_ARGUMENTS)
    get_filename_component(model "${model}" ABSOLUTE)
    if(NOT EXISTS "${model}")
      message(FATAL_ERROR "pk_add_model(${target}): there is no ${model}")
    endif()
    # The statement `model NAME` names the C.
    file(STRINGS "${model}" statement REGEX "^[ \t]*model[ \t]+[A-Za-z_]" LIMIT_COUNT 1)
    string(REGEX REPLACE "^[ \t]*model[ \t]+([A-Za-z0-9_]+).*" "\\1" name "${statement}")
    if(NOT name)
      message(FATAL_ERROR "pk_add_model(${target}): ${model} has no statement `model NAME`")
    endif()
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${model}")
    set(stem "${folder}/${name}")
    set(made "${stem}.c" "${stem}.h")
    if(form)
      list(APPEND made "${stem}_system.c" "${stem}_system.h")
    endif()
    add_custom_command(
      OUTPUT ${made}
      COMMAND "${pk_PKGEN}" "${model}" -o "${folder}" --depfile "${stem}.d" ${form} ${pk_OPTIONS}
      DEPENDS "${model}" "${pk_PKGEN}"
      DEPFILE "${stem}.d"
      COMMENT "pkgen ${name}"
      VERBATIM)
    target_sources(${target} PRIVATE "${stem}.c" "${stem}.h")
    if(NOT "C" IN_LIST languages)
      set_source_files_properties("${stem}.c" PROPERTIES LANGUAGE CXX)
    endif()
    if(NOT MSVC) # the same bits with every compiler
      set_source_files_properties("${stem}.c" PROPERTIES
        COMPILE_OPTIONS "-ffp-contract=off;-fno-math-errno")
    endif()
  endforeach()
  target_include_directories(${target} PUBLIC "${folder}")
  if(pk_WITHOUT_RUNTIME)
    target_link_libraries(${target} PUBLIC "$<$<NOT:$<BOOL:${WIN32}>>:m>")
  else()
    target_link_libraries(${target} PUBLIC pk::pk)
  endif()
endfunction()
