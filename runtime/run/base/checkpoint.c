/* The file of a checkpoint; see checkpoint.h. Numbers are stored as in memory; `order` and `real`
 * in the header detect a machine with another byte order or size of pk_real. */
#define _POSIX_C_SOURCE 200809L

#include "checkpoint.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#define MAGIC "pkgen checkpoint"
#define ORDER 0x0102030405060708u

enum { VERSION = 2, SUMMED = 24, TAIL = 1 << 16 };

struct head {
    char magic[16];
    uint32_t version, sum; /* `sum`: CRC-32 of all bytes after it */
    uint64_t order, size;  /* `order`: the constant ORDER; `size`: bytes in the file */
    uint32_t real, note;   /* `real`: sizeof(pk_real); `note`: bytes in the note after the header */
};

uint32_t checkpoint_sum(uint32_t before, const void *bytes, size_t size)
{
    static const uint32_t nibble[16] = {0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac,
                                        0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
                                        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c,
                                        0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    const unsigned char *byte = bytes;
    uint32_t sum = ~before;
    for (size_t i = 0; i < size; i++) {
        sum ^= byte[i];
        sum = sum >> 4 ^ nibble[sum & 15];
        sum = sum >> 4 ^ nibble[sum & 15];
    }
    return ~sum;
}

static int all_written(int fd, const void *bytes, size_t size)
{
    const char *at = bytes;
    while (size) {
        const ssize_t done = write(fd, at, size);
        if (done < 0 && errno != EINTR)
            return 0;
        at += done > 0 ? done : 0;
        size -= done > 0 ? (size_t)done : 0;
    }
    return 1;
}

/* Syncs the folder of `path`, which completes a rename on disk. `name` is a buffer for its name. */
static void settle_folder(const char *path, char *name)
{
    const char *slash = strrchr(path, '/');
    const size_t length = slash ? (size_t)(slash - path) + 1 : 0;
    memcpy(name, length ? path : "./", length ? length : 2);
    name[length ? length : 2] = '\0';
    const int folder = open(name, O_RDONLY);
    if (folder >= 0) {
        fsync(folder);
        close(folder);
    }
}

int checkpoint_store(struct memory *memory, const char *path, const char *note,
                     const unsigned char *bytes, size_t size)
{
    struct head head = {.version = VERSION, .order = ORDER, .real = sizeof(pk_real)};
    memcpy(head.magic, MAGIC, sizeof head.magic);
    head.note = (uint32_t)strlen(note);
    head.size = sizeof head + head.note + size;
    head.sum = checkpoint_sum(0, (const char *)&head + SUMMED, sizeof head - SUMMED);
    head.sum = checkpoint_sum(head.sum, note, head.note);
    head.sum = checkpoint_sum(head.sum, bytes, size);
    char *beside = memory_take(memory, strlen(path) + sizeof ".new" + 2, 1);
    strcat(strcpy(beside, path), ".new");
    /* Only the file's owner may read or write it. Before it resumes, pkgen checks who the owner is.
     */
    const int fd = open(beside, O_WRONLY | O_CREAT | O_TRUNC | O_NOFOLLOW, 0600);
    int wrong = fd < 0 || !all_written(fd, &head, sizeof head) ||
                        !all_written(fd, note, head.note) || !all_written(fd, bytes, size) ||
                        fsync(fd)
                    ? errno
                    : 0;
    if (fd >= 0 && close(fd) && !wrong)
        wrong = errno;
    if (!wrong && rename(beside, path))
        wrong = errno;
    if (wrong && fd >= 0)
        unlink(beside);
    if (!wrong)
        settle_folder(path, beside);
    memory_drop(memory, beside);
    return wrong;
}

static size_t all_read(int fd, unsigned char *bytes, size_t size)
{
    size_t had = 0;
    while (had < size) {
        const ssize_t done = read(fd, bytes + had, size - had);
        if (done == 0 || (done < 0 && errno != EINTR))
            break;
        had += done > 0 ? (size_t)done : 0;
    }
    return had;
}

static const char *unfit(const struct head *head, size_t size)
{
    if (size < sizeof *head || memcmp(head->magic, MAGIC, sizeof head->magic) != 0)
        return "it is no checkpoint of pkgen";
    if (head->version != VERSION)
        return "it is of another version of pkgen";
    if (head->order != ORDER || head->real != sizeof(pk_real))
        return "it is of another kind of machine, or of other numbers";
    if (head->size != size || head->note > size - sizeof *head)
        return "it is cut short";
    if (checkpoint_sum(0, (const char *)head + SUMMED, size - SUMMED) != head->sum)
        return "it is damaged: its sum is not that of its bytes";
    return NULL;
}

const unsigned char *checkpoint_load(struct memory *memory, const char *path, size_t *size,
                                     const char **why)
{
    struct stat is;
    const int fd = open(path, O_RDONLY | O_NONBLOCK);
    unsigned char *bytes = NULL;
    *why = NULL;
    if (fd < 0 || fstat(fd, &is))
        *why = strerror(errno);
    else if (!S_ISREG(is.st_mode))
        *why = "it is no file";
    if (!*why) {
        bytes = memory_ask(memory, (size_t)is.st_size + sizeof(struct head), 1);
        *size = bytes ? all_read(fd, bytes, (size_t)is.st_size) : 0;
        *why = bytes ? unfit((const struct head *)(const void *)bytes, *size) : "out of memory";
    }
    if (fd >= 0)
        close(fd);
    if (*why)
        return NULL;
    const size_t before = sizeof(struct head) + ((const struct head *)(const void *)bytes)->note;
    *size -= before;
    return bytes + before;
}

/* Sets *sum to the CRC-32 of the place->tail bytes before the offset place->at; returns 0 if these
 * bytes cannot be read. `fd` may be write-only: it is opened again as /dev/fd/N, if possible. */
static int tail_sum(int fd, const struct place *place, uint64_t *sum)
{
    unsigned char bytes[TAIL];
    char name[40];
    snprintf(name, sizeof name, "/dev/fd/%d", fd);
    const int again = open(name, O_RDONLY);
    if (again < 0)
        return 0;
    const int there = lseek(again, (off_t)(place->at - place->tail), SEEK_SET) >= 0;
    const size_t had = there ? all_read(again, bytes, (size_t)place->tail) : 0;
    close(again);
    *sum = checkpoint_sum(0, bytes, had);
    return there && had == place->tail;
}

struct place checkpoint_place(FILE *out)
{
    struct place place = {0};
    struct stat is;
    const int fd = out && !fflush(out) ? fileno(out) : -1;
    if (fd < 0 || fstat(fd, &is) || !S_ISREG(is.st_mode))
        return place;
    const off_t at = lseek(fd, 0, SEEK_CUR);
    place.at = at > 0 ? (uint64_t)at : 0;
    place.tail = place.at < TAIL ? place.at : TAIL;
    place.whole = at >= 0 && !fsync(fd) && tail_sum(fd, &place, &place.sum);
    return place;
}

const char *checkpoint_cut(FILE *out, const struct place *place)
{
    struct stat is;
    uint64_t sum;
    const int fd = fileno(out);
    if (!place->whole || fstat(fd, &is) || !S_ISREG(is.st_mode) || is.st_size == 0)
        return NULL;
    if (place->tail > place->at || place->tail > TAIL || (uint64_t)is.st_size < place->at)
        return "the rows that were written before it are not all there";
    if (!tail_sum(fd, place, &sum) || sum != place->sum)
        return "the rows before it are not those that the run had written";
    if (ftruncate(fd, (off_t)place->at) || lseek(fd, (off_t)place->at, SEEK_SET) < 0)
        return strerror(errno);
    return NULL;
}
