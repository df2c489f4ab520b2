/* Checkpoints: when they are written, and what they contain: the hash of the model, the marks of
 * the settings, the end of the rows, and the state of the run. */
#include <pk/keep.h>

#include "../base/checkpoint.h"
#include "checkpoint.h"

static enum pk_status everything(struct pk_run *run, checkpoint_keep *keep, void *context,
                                 struct pk_keep *k)
{
    PK_KEEP(k, run->seconds);
    PK_KEEP(k, run->processor);
    const enum pk_status status = keep(run, context, k);
    observe_keep(run, k);
    return status < 0 ? status : k->wrong ? PK_BLOCK_TOO_SMALL : PK_DONE;
}

/* A checkpoint belongs to one run: hash of its model (64 characters), hashes of its settings
 * (marks). `rows` is the end of its rows in their file. */
struct of {
    char model[64];
    uint64_t marks[MARKS];
    struct place rows;
};

static struct of of_run(const struct pk_run *run)
{
    struct of of = {.rows = {0}};
    strncpy(of.model, run->settings.system->source_hash, sizeof of.model);
    for (size_t i = 0; i < MARKS; i++)
        of.marks[i] = run->settings.marks[i].of;
    return of;
}

static int refuse(struct pk_run *run, const char *why, const char *which)
{
    run->checkpoint.refused = 1;
    run_say(run, "cannot go on from %s: %s%s", run->settings.asked.checkpoint, why, which);
    return 0;
}

static int resume(struct pk_run *run, checkpoint_keep *keep, void *context)
{
    const char *why;
    struct pk_keep k = {0};
    struct of is, now = of_run(run);
    k.from = checkpoint_load(&run->memory, run->settings.asked.checkpoint, &k.size, &why);
    if (!k.from)
        return refuse(run, why, "");
    PK_KEEP(&k, is);
    if (k.wrong || memcmp(is.model, now.model, sizeof is.model) != 0)
        return refuse(run, "it is of another model, or this one was changed", "");
    for (size_t i = 0; i < MARKS; i++)
        if (is.marks[i] != now.marks[i])
            return refuse(run, "the run had another setting: ", run->settings.marks[i].name);
    if (everything(run, keep, context, &k) < 0 || k.used != k.size)
        return refuse(run, "what is in it is not of this run", "");
    why = run->out ? checkpoint_cut(run->out, &is.rows) : NULL;
    if (why)
        return refuse(run, why, "");
    return run->checkpoint.resumed = 1;
}

int checkpoint_begin(struct pk_run *run, checkpoint_keep *keep, void *context)
{
    struct pk_keep k = {0};
    if (!run->settings.asked.checkpoint)
        return 1;
    run->checkpoint.last = run_now();
    if (everything(run, keep, context, &k) == PK_REFUSED) {
        run->checkpoint.refused = 1;
        run_say(run, "there are no checkpoints of %s: what it remembers of its steps is GSL's own",
                run->settings.method->name);
        return 0;
    }
    return run->settings.asked.resume ? resume(run, keep, context) : 1;
}

void checkpoint_write(struct pk_run *run, checkpoint_keep *keep, void *context)
{
    const struct pk_run_settings *asked = &run->settings.asked;
    const char *note = run->settings.asked.checkpoint_note;
    struct of of = of_run(run);
    struct pk_keep k = {0};
    const double seconds = run->seconds, processor = run->processor;
    if (run->write_failed) /* some rows are missing in the file */
        return;
    run->seconds += run_now() - run->checkpoint.began;
    run->processor += run_processor() - run->control.began;
    of.rows = checkpoint_place(run->out);
    everything(run, keep, context, &k);
    k.size = k.used + sizeof of;
    /* if memory runs out, the run continues without this checkpoint */
    k.to = memory_ask(&run->memory, k.size, 1);
    k.used = 0;
    PK_KEEP(&k, of);
    if (k.to)
        everything(run, keep, context, &k);
    const int wrong =
        k.to ? checkpoint_store(&run->memory, asked->checkpoint, note ? note : "", k.to, k.size)
             : ENOMEM;
    memory_drop(&run->memory, k.to);
    run->seconds = seconds;
    run->processor = processor;
    run->checkpoint.last = run_now();
    run->checkpoint.written = !wrong;
    if (wrong && run->checkpoint.failures++ == 0)
        run_say(run, "cannot write %s: %s", asked->checkpoint, strerror(wrong));
}

void checkpoint_look(struct pk_run *run, checkpoint_keep *keep, void *context)
{
    const struct pk_run_settings *asked = &run->settings.asked;
    struct checkpoint *c = &run->checkpoint;
    if (!asked->checkpoint || run->control.slow)
        return;
    if (asked->checkpoint_after && ++c->looks >= asked->checkpoint_after)
        run->interrupted = run->control.stop = 1;
    const int ends = run->interrupted || run->control.stop;
    if (!ends &&
        !(asked->checkpoint_every > 0 && run->control.looked - c->last >= asked->checkpoint_every))
        return;
    checkpoint_write(run, keep, context);
    c->left = ends && c->written;
}
