#pragma once
/* The C interface of our crate around minijinja. C++ uses cx/template, which is the only user. */

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* UTF-8 without a final zero; it stays valid as long as the function runs that it is passed to. */
typedef struct {
  const char* data;
  size_t size;
} minijinja_text;

typedef struct {
  minijinja_text name;      /* the template to render */
  minijinja_text variables; /* a JSON object */
  int html;        /* 0: as Jinja's defaults; else values are escaped for HTML, and printing an undefined one fails */
  uint64_t fuel;   /* instructions that may run */
  uint64_t output; /* bytes of text that may be made */
  uint64_t memory; /* bytes that may be allocated at the same time, besides the text */
  void* context;   /* passed to the functions */
  /* The functions must not throw. `load` and `write` run in another thread while the caller waits. */
  /* Sets `text` and returns 1, or returns 0 if there is no such template. `text` stays valid until the next call. */
  int (*load)(void* context, minijinja_text name, minijinja_text* text);
  /* Takes the next piece of the text. */
  void (*write)(void* context, minijinja_text text);
  /* Called at the end if rendering has failed. `line` is 0 if it is unknown. */
  void (*fail)(void* context, minijinja_text file, size_t line, minijinja_text message);
} minijinja_job;

void minijinja_render(const minijinja_job* job);

#ifdef __cplusplus
}
#endif
