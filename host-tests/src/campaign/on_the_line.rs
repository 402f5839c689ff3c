//! Faults of the line.

use hysteron::control::Path;
use hysteron::link::{Answer, Command, Refusal, VERSION};
use hysteron::reference::{Tone, Waveform};

use super::dice::Dice;
use super::judge::{FAULT, HOLD, OFF, RUN};
use super::line;
use super::material::{anywhere, change, chunks, complete, model, play, settings, stream};
use super::rig::{Rig, Stop, Subject, broken};

/// How often a command is repeated over a noisy line.
const TRIES: usize = 60;
/// Samples of a stream; it fits into the queue, in several frames.
const STREAM: usize = 200;

/// A frame that is spoilt: no reply, counted once, and the output is as it was.
pub fn spoilt<S: Subject>(
    rig: &mut Rig<S>,
    spoil: fn(&[u8], &mut Dice) -> Vec<u8>,
) -> Result<(), Stop> {
    let state = anywhere(rig)?;
    let before = rig.statistics()?.bad_frames;
    let command = change(&mut rig.dice);
    let (_, frame) = rig.frame(&command)?;
    let bytes = spoil(&frame, &mut rig.dice);
    if let Some(reply) = rig.send(&bytes)?.first() {
        return broken(format!("a spoilt frame is answered: {reply:?}"));
    }
    let now = rig.ticks(4)?.state;
    if now != state {
        return broken(format!("a spoilt frame leads from state {state} to {now}"));
    }
    let counted = rig.statistics()?.bad_frames.wrapping_sub(before);
    if counted != 1 {
        return broken(format!("a spoilt frame is counted {counted} times"));
    }
    Ok(())
}

/// The same frame twice: two answers, and what it says is in force.
pub fn duplicate<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let samples = stream(rig, 64);
    rig.tell(&Command::ResetStream)?;
    let mut commands = chunks(&samples);
    commands.push(change(&mut rig.dice));
    for command in commands {
        rig.ticks(3)?;
        let (_, mut frame) = rig.frame(&command)?;
        frame.extend(frame.clone());
        let answers = rig.send(&frame)?.len();
        if answers != 2 {
            return broken(format!("{answers} answers to a frame that came twice"));
        }
    }
    rig.ticks(3)?;
    // Settings may have changed with it: a stream is good for those that it was made for.
    let samples = stream(rig, 64);
    rig.tell(&Command::ResetStream)?;
    complete(rig, &samples)?;
    complete(rig, &samples)?;
    play(rig)
}

/// The frames of a stream in any order, then again in theirs.
pub fn reordering<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let samples = stream(rig, STREAM);
    rig.tell(&Command::ResetStream)?;
    let chunks = chunks(&samples);
    for at in rig.dice.order(chunks.len()) {
        rig.ask(&chunks[at])?;
    }
    complete(rig, &samples)?;
    play(rig)
}

/// Bytes that no host sends.
pub fn random_frame<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    anywhere(rig)?;
    let len = rig.dice.below(700);
    let random = rig.dice.bytes(len);
    // Bodies that are commands by chance are those of `random_commands`: here none changes anything.
    let bytes = match rig.dice.below(3) {
        0 => line::framed(
            VERSION.wrapping_add(1 + rig.dice.below(255) as u8),
            &random,
            0,
        ),
        1 => {
            // Numbers of commands end at 14.
            let mut body = vec![rig.dice.below(128) as u8, 15 + rig.dice.below(100) as u8];
            body.extend(random);
            line::framed(VERSION, &body, 0)
        }
        _ => random,
    };
    rig.send(&bytes)?;
    rig.ticks(3)?;
    Ok(())
}

/// A valid command with any values.
fn any_command(dice: &mut Dice) -> Command {
    let any = |dice: &mut Dice| f32::from_bits(dice.bits() as u32);
    let value = |dice: &mut Dice| {
        if dice.one_in(4) {
            any(dice)
        } else {
            dice.real(-60.0, 60.0)
        }
    };
    let tone = |dice: &mut Dice| Tone {
        amplitude: value(dice),
        frequency_hz: dice.real(0.0, 3_000.0),
    };
    match dice.below(12) {
        0 => Command::SetSettings(settings(dice)),
        1 => Command::SetModel(Some(model(dice))),
        2 => Command::SetModel(None),
        3 | 4 => Command::Start {
            path: if dice.one_in(2) {
                Path::Direct
            } else {
                Path::Compensated
            },
            waveform: match dice.below(3) {
                0 => Waveform::Stream,
                1 => Waveform::Triangle {
                    offset: value(dice),
                    tone: tone(dice),
                },
                _ => Waveform::Tones {
                    offset: value(dice),
                    tones: [tone(dice), tone(dice)],
                },
            },
            samples: dice.below(60) as u32,
        },
        5 => Command::Hold,
        6 => Command::Stop,
        7 => Command::Clear,
        8 => Command::ResetStream,
        9 => Command::Stream {
            first: dice.below(3) as u32 * 32,
            samples: (0..dice.below(65)).map(|_| value(dice)).collect(),
        },
        10 => Command::Record {
            every: dice.below(3) as u32,
        },
        _ => Command::Save,
    }
}

/// A host out of its mind.
pub fn random_commands<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    for _ in 0..10 + rig.dice.below(30) {
        let command = any_command(&mut rig.dice);
        rig.ask(&command)?;
        for _ in 0..rig.dice.below(4) {
            rig.tick(false)?;
        }
    }
    rig.tell(&Command::Record { every: 0 })
}

/// Repeats a command over a line that spoils both ways until its answer is heard.
fn through_noise<S: Subject>(
    rig: &mut Rig<S>,
    command: &Command,
    one_in: usize,
) -> Result<(), Stop> {
    let (sent, frame) = rig.frame(command)?;
    for _ in 0..TRIES {
        let mut bytes = vec![0];
        bytes.extend(line::noisy(&frame, one_in, &mut rig.dice));
        let replies = rig.send(&bytes)?;
        rig.ticks(2)?;
        // The reply has to come through, too: some twenty bytes.
        let heard = (0..20).all(|_| !rig.dice.one_in(one_in));
        let own = |(sequence, answer): &(u16, Answer)| {
            *sequence == sent && *answer != Answer::Refused(Refusal::Busy)
        };
        if heard && replies.iter().any(own) {
            return Ok(());
        }
    }
    broken(format!(
        "not through a noisy line in {TRIES} tries: {command:?}"
    ))
}

/// Noise on the line.
pub fn noise<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let one_in = 120 + rig.dice.below(2_000);
    let settings = settings(&mut rig.dice);
    through_noise(rig, &Command::SetSettings(settings), one_in)?;
    let model = model(&mut rig.dice);
    through_noise(rig, &Command::SetModel(Some(model)), one_in)?;
    rig.ticks(3)?;
    rig.tell(&Command::ResetStream)?;
    let samples = stream(rig, STREAM);
    // Frames of 60 bytes: longer ones seldom come through at the worst of it.
    for (at, samples) in samples.chunks(12).enumerate() {
        let chunk = Command::Stream {
            first: (at * 12) as u32,
            samples: samples.iter().copied().collect(),
        };
        through_noise(rig, &chunk, one_in)?;
    }
    complete(rig, &samples)?;
    play(rig)
}

/// Every reply is lost, every command is sent again under the same number.
pub fn lost_reply<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let mut commands = vec![
        Command::SetSettings(settings(&mut rig.dice)),
        Command::SetModel(Some(model(&mut rig.dice))),
        Command::ResetStream,
    ];
    for command in commands.drain(..) {
        for _ in 0..2 + rig.dice.below(3) {
            let (_, frame) = rig.frame(&command)?;
            rig.send(&frame)?;
            rig.ticks(3)?;
        }
    }
    let samples = stream(rig, STREAM);
    for chunk in chunks(&samples) {
        let (_, frame) = rig.frame(&chunk)?;
        for _ in 0..2 {
            rig.send(&frame)?;
        }
    }
    complete(rig, &samples)?;
    play(rig)
}

/// The line breaks within a frame while a stream is played.
pub fn link_cut<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let samples = stream(rig, STREAM);
    rig.tell(&Command::ResetStream)?;
    let chunks = chunks(&samples);
    let whole = 1 + rig.dice.below(chunks.len() - 1);
    for chunk in &chunks[..whole] {
        rig.ask(chunk)?;
    }
    let (_, frame) = rig.frame(&chunks[whole])?;
    let cut = rig.dice.below(frame.len() - 1);
    rig.send(&frame[..cut])?;
    // `play` asks for a counter at its end: the line is there again by then, the stream is not.
    rig.send(&[0])?;
    play(rig)?;
    dies_away(rig)
}

/// A stream that has run dry is waited for, at the last sample; then the output comes to rest.
fn dies_away<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let settings = rig.judge.settings();
    let stale = (settings.stale_s * settings.sample_rate_hz) as usize;
    let first = rig.tick(false)?;
    let last = rig.ticks(stale.saturating_sub(1))?;
    if last.state != RUN || last.code != first.code {
        return broken(format!("within stale time: {first:?}, then {last:?}"));
    }
    let rest = 2 + rig.way_to_rest();
    let last = rig.ticks(rest)?;
    if last.state != OFF || last.driver_enabled {
        return broken(format!("after stale time: {last:?}"));
    }
    Ok(())
}

/// Commands without a pause.
pub fn flood<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    anywhere(rig)?;
    let mut bytes = Vec::new();
    let mut sent = Vec::new();
    for _ in 0..50 + rig.dice.below(101) {
        let command = match rig.dice.below(5) {
            0 => change(&mut rig.dice),
            1 => Command::Hold,
            2 => Command::Stop,
            3 => Command::Record { every: 0 },
            _ => Command::Statistics,
        };
        let (sequence, frame) = rig.frame(&command)?;
        sent.push(sequence);
        bytes.extend(frame);
    }
    let replies = rig.send(&bytes)?;
    if !replies.iter().map(|(sequence, _)| sequence).eq(&sent) {
        return broken(format!("{} replies to {}", replies.len(), sent.len()));
    }
    let state = rig.ticks(8)?.state;
    if state == FAULT && rig.statistics()?.cause.is_none() {
        return broken("a fault without a cause");
    }
    Ok(())
}

/// A stream that pauses, shorter and longer than stale time.
pub fn stale<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let samples = stream(rig, 128);
    rig.tell(&Command::ResetStream)?;
    let chunks = chunks(&samples);
    rig.ask(&chunks[0])?;
    play(rig)?;
    if rig.dice.one_in(2) {
        return dies_away(rig);
    }
    let settings = rig.judge.settings();
    let stale = (settings.stale_s * settings.sample_rate_hz) as usize;
    let pause = 1 + rig.dice.below(stale - 1);
    rig.ticks(pause)?;
    rig.ask(&chunks[1])?;
    // Both samples of a motion that goes on where it stood.
    let last = rig.ticks(64)?;
    let count = rig.statistics()?.played;
    if last.state != RUN || count != 128 {
        return broken(format!("{count} samples of 128 after a pause, {last:?}"));
    }
    dies_away(rig)
}

/// A stream that is emptied while it is emptied already.
pub fn stream_resets<S: Subject>(rig: &mut Rig<S>) -> Result<(), Stop> {
    let len = 40 + rig.dice.below(600);
    let old = stream(rig, len);
    rig.tell(&Command::ResetStream)?;
    complete(rig, &old)?;
    for _ in 0..1 + rig.dice.below(3) {
        rig.insist(&Command::ResetStream)?;
        for _ in 0..rig.dice.below(4) {
            rig.tick(false)?;
        }
        if rig.dice.one_in(2) {
            let model = model(&mut rig.dice);
            rig.insist(&Command::SetModel(Some(model)))?;
            for _ in 0..rig.dice.below(3) {
                rig.tick(false)?;
            }
        }
    }
    let samples = stream(rig, 64);
    complete(rig, &samples)?;
    // The sample after a swap obeys no order, and the start is to be obeyed in the one that comes next.
    let last = rig.ticks(6)?.state;
    if !matches!(last, OFF | HOLD) {
        return broken(format!("a stream that is emptied leads to state {last}"));
    }
    play(rig)
}
