//! The instruments on programs of a few words whose cycles can be counted by hand.

use super::Trace;
use crate::devices::Bus;
use crate::firmware_image::FirmwareImage;
use crate::nano::{CLOCK_HZ, Nano};

const NOP: u16 = 0x0000;
const RETI: u16 = 0x9518;
const TO_SELF: u16 = 0xCFFF;
/// Words before the program: 26 vectors of two words each.
const VECTOR_WORDS: usize = 52;
/// TIMER1_COMPA, and where its handler stands here.
const VECTOR: u8 = 11;
const HANDLER: u16 = 0x60;

/// A main program behind the vectors, and a handler for timer 1's compare A.
fn program(main: &[u16], handler: &[u16]) -> FirmwareImage {
    let mut words = vec![NOP; usize::from(HANDLER)];
    // jmp to the main program, and to the handler.
    words[..2].copy_from_slice(&[0x940C, VECTOR_WORDS as u16]);
    words[usize::from(VECTOR) * 2..][..2].copy_from_slice(&[0x940C, HANDLER]);
    words[VECTOR_WORDS..VECTOR_WORDS + main.len()].copy_from_slice(main);
    words.extend_from_slice(handler);
    words.push(TO_SELF);
    FirmwareImage::of_words(&words)
}

/// Timer 1 counts cycles and matches every 1,000 of them, interrupt on:
/// ldi r16,0x03; sts OCR1AH; ldi r16,0xE7; sts OCR1AL; ldi r16,2; sts TIMSK1;
/// ldi r16,0x09; sts TCCR1B.
const START_TIMER: [u16; 12] =
    [0xE003, 0x9300, 0x0089, 0xEE07, 0x9300, 0x0088, 0xE002, 0x9300, 0x006F, 0xE009, 0x9300, 0x0081];
const SEI: u16 = 0x9478;
const CLI: u16 = 0x94F8;

fn traced(image: &FirmwareImage, trace: Trace, cycles: u64) -> Trace {
    let mut nano = Nano::new(image, Bus::default()).unwrap();
    nano.run_until(60).unwrap();
    nano.start_trace(trace);
    nano.run_until(60 + cycles).unwrap();
    nano.take_trace().unwrap()
}

#[test]
fn a_handlers_time_is_its_entry_its_jump_its_instructions_and_its_return() {
    let main = [&START_TIMER[..], &[SEI, TO_SELF]].concat();
    let image = program(&main, &[NOP, NOP, RETI]);

    let trace = traced(&image, Trace::new(), 10_000);

    let handler = trace.interrupts.handlers()[0];
    // 4 in, 3 for the jump, 2, and 4 out.
    assert_eq!((handler.vector, handler.longest.cycles), (VECTOR, 13));
    assert!((9..=10).contains(&handler.count), "{}", handler.count);
    assert_eq!(trace.interrupts.longest_off().unwrap().cycles, 13);
}

#[test]
fn a_longer_handler_is_seen_to_be_longer() {
    let main = [&START_TIMER[..], &[SEI, TO_SELF]].concat();
    let handler = [&[NOP; 100][..], &[RETI]].concat();

    let trace = traced(&program(&main, &handler), Trace::new(), 10_000);

    assert_eq!(trace.interrupts.longest_handler().unwrap().longest.cycles, 111);
}

#[test]
fn interrupts_that_the_main_program_holds_off_are_seen_where_it_does() {
    // cli; 5 nops; sei; rjmp to the cli.
    let main = [&START_TIMER[..], &[CLI, NOP, NOP, NOP, NOP, NOP, SEI, 0xCFF8]].concat();

    let trace = traced(&program(&main, &[RETI]), Trace::new(), 900);

    let off = trace.interrupts.longest_off_in_main().unwrap();
    // From the end of `cli` to the end of `sei`.
    assert_eq!(off.cycles, 6);
    assert_eq!(off.pc as usize, 2 * (VECTOR_WORDS + START_TIMER.len()));
}

/// A loop that counts to 10 in r18 and then writes a new number to address 0x0120:
/// ldi r18,10; head: dec r18; brne head; inc r19; sts 0x0120,r19; ldi r18,10; rjmp head.
/// With `works` false the number stays what it was.
fn counting(works: bool) -> FirmwareImage {
    let step = if works { 0x9533 } else { NOP };
    program(&[0xE02A, 0x952A, 0xF7F1, step, 0x9330, 0x0120, 0xE02A, 0xCFF9], &[RETI])
}

#[test]
fn the_main_loop_is_found_by_its_outermost_backward_jump() {
    let trace = traced(&counting(true), Trace::new(), 1_000);

    assert_eq!(trace.finder.head(), Some(2 * (VECTOR_WORDS as u32 + 1)));
}

#[test]
fn a_loop_that_changes_nothing_is_idle_and_one_that_works_is_busy() {
    // The pass from one end of the inner loop to the next: its last instruction.
    let head = 2 * (VECTOR_WORDS as u32 + 7);

    let idle = traced(&counting(false), Trace::of_loop(head, 0x200), 10_000);
    let busy = traced(&counting(true), Trace::of_loop(head, 0x200), 10_000);

    assert!(idle.passes.unwrap().busy().unwrap() < 0.01);
    assert!(busy.passes.unwrap().busy().unwrap() > 0.99);
}

#[test]
fn a_handlers_cycles_are_busy_though_the_loop_is_idle() {
    // The loop is one jump; the handler takes 111 of every 1,000 cycles.
    let main = [&START_TIMER[..], &[SEI, TO_SELF]].concat();
    let head = 2 * (VECTOR_WORDS + START_TIMER.len() + 1) as u32;
    let handler = [&[NOP; 100][..], &[RETI]].concat();

    let trace = traced(&program(&main, &handler), Trace::of_loop(head, 0x200), 100_000);

    let busy = trace.passes.unwrap().busy().unwrap();
    assert!((busy - 0.111).abs() < 0.002, "{busy}");
}

#[test]
fn the_stack_is_seen_at_its_deepest_and_never_at_half_a_pointer() {
    // SP goes from 0x0805 to 0x07F0 in two halves, then one byte is pushed:
    // ldi r16,8; out SPH; ldi r16,5; out SPL; ldi r16,7; out SPH; ldi r16,0xF0;
    // out SPL; push r16; rjmp .
    let main = [0xE008, 0xBF0E, 0xE005, 0xBF0D, 0xE007, 0xBF0E, 0xEF00, 0xBF0D, 0x930F, TO_SELF];
    let mut nano = Nano::new(&program(&main, &[RETI]), Bus::default()).unwrap();

    nano.start_trace(Trace::new());
    nano.run_until(100).unwrap();

    assert_eq!(nano.take_trace().unwrap().lowest_stack, Some(0x07EF));
}

#[test]
fn a_transfer_on_a_stuck_bus_lasts_until_the_program_gives_it_up_and_frees_the_lines() {
    // ldi r16,0xA4 (TWINT, TWSTA, TWEN); sts TWCR; 20 nops; clr; sts TWCR;
    // sbi DDRC,5; cbi DDRC,5; rjmp .
    let main =
        [&[0xEA04, 0x9300, 0x00BC][..], &[NOP; 20], &[0xE000, 0x9300, 0x00BC, 0x9A3D, 0x983D, TO_SELF]]
            .concat();
    let mut nano = Nano::new(&program(&main, &[RETI]), Bus::default()).unwrap();
    nano.hold_data_line(1);

    nano.start_trace(Trace::new());
    nano.run_until(CLOCK_HZ / 1_000).unwrap();

    let trace = nano.take_trace().unwrap();
    let [transfer] = trace.bus.transfers() else { panic!("{:?}", trace.bus) };
    // 20 nops, ldi and sts to the end; sbi and cbi to the freed line.
    assert_eq!(transfer.ended - transfer.began, 23);
    assert_eq!(transfer.cycles(), 27);
    assert!(!nano.bus().is_data_held(), "one clock frees it");
}

#[test]
fn a_received_byte_waits_until_the_program_reads_it() {
    // ldi r18,2; sts UCSR0A; ldi r18,16; sts UBRR0L; ldi r18,0x10; sts UCSR0B;
    // head: 200 nops; lds r16,UDR0; rjmp head.
    let set_up = [0xE022, 0x9320, 0x00C0, 0xE120, 0x9320, 0x00C4, 0xE120, 0x9320, 0x00C1];
    let main = [&set_up[..], &[NOP; 200], &[0x9100, 0x00C6, 0xCF35]].concat();
    let mut nano = Nano::new(&FirmwareImage::of_words(&main), Bus::default()).unwrap();

    nano.start_trace(Trace::new());
    for _ in 0..20 {
        nano.send(b"x");
        nano.run_until(nano.now() + 1_517).unwrap();
    }

    let wait = nano.take_trace().unwrap().interrupts.longest_receive_wait().unwrap();
    // A pass takes 204 cycles, and no byte waits longer.
    assert!((150..=204).contains(&wait), "{wait}");
}
