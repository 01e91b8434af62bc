#include "benchmarks/rules_baseline.h"

#include <clips.h>
#include <stdlib.h>

struct Baseline {
  Environment* env;
  FactBuilder* messages;
};

static void create(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue arg;
  if (!UDFFirstArgument(context, LEXEME_BITS, &arg)) return;
  result->externalAddressValue = CreateCExternalAddress(env, (void*)2);
}

static void destroy(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue arg;
  (void)env;
  (void)result;
  UDFFirstArgument(context, EXTERNAL_ADDRESS_BIT, &arg);
}

static void get(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue arg;
  if (!UDFFirstArgument(context, EXTERNAL_ADDRESS_BIT, &arg) || !UDFNextArgument(context, LEXEME_BITS, &arg)) return;
  result->floatValue = CreateFloat(env, 0.5);
}

static void set(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue arg;
  (void)env;
  (void)result;
  if (UDFFirstArgument(context, EXTERNAL_ADDRESS_BIT, &arg) && UDFNextArgument(context, LEXEME_BITS, &arg))
    UDFNextArgument(context, ANY_TYPE_BITS, &arg);
}

static void publish(Environment* env, UDFContext* context, UDFValue* result) {
  UDFValue arg;
  (void)env;
  (void)result;
  if (UDFFirstArgument(context, EXTERNAL_ADDRESS_BIT, &arg)) UDFNextArgument(context, LEXEME_BITS, &arg);
}

struct Baseline* baseline_create(const char* deftemplate, const char* rule) {
  struct Baseline* baseline = calloc(1, sizeof *baseline);
  Environment* env = baseline->env = CreateEnvironment();
  AddUDF(env, "ros-msgs-create-message", "e", 1, 1, ";sy", create, "create", NULL);
  AddUDF(env, "ros-msgs-destroy-message", "v", 1, 1, ";e", destroy, "destroy", NULL);
  AddUDF(env, "ros-msgs-get-field", "*", 2, 2, ";e;sy", get, "get", NULL);
  AddUDF(env, "ros-msgs-set-field", "v", 3, 3, ";e;sy;*", set, "set", NULL);
  AddUDF(env, "ros-msgs-publish", "v", 2, 2, ";e;sy", publish, "publish", NULL);
  if (Build(env, deftemplate) != BE_NO_ERROR || Build(env, rule) != BE_NO_ERROR) {
    baseline_destroy(baseline);
    return NULL;
  }
  baseline->messages = CreateFactBuilder(env, "ros-msgs-message");
  return baseline;
}

long long baseline_cycle(struct Baseline* baseline) {
  Environment* env = baseline->env;
  FBPutSlotString(baseline->messages, "topic", "pose");
  FBPutSlotCLIPSExternalAddress(baseline->messages, "msg-ptr", CreateCExternalAddress(env, (void*)1));
  FBAssert(baseline->messages);
  return Run(env, -1);
}

void baseline_destroy(struct Baseline* baseline) {
  if (baseline->messages != NULL) FBDispose(baseline->messages);
  DestroyEnvironment(baseline->env);
  free(baseline);
}
