// Two widgets beside an element in Jupyter, one for a question and one for its answer,
// are a line to the package; the page takes over what it leaves unanswered.
export function line(home, start) {
  const PATIENCE = 10, LONG = 60,  // seconds for an answer, and for gains that are searched
    ATTEMPTS = 50;                 // tries, 0.1 s apart, to find the widgets
  return receive => {
    let due = null, timer = null, spare = null, known = null;
    const taken = answer => {
      clearTimeout(timer);
      due = null;
      receive(answer);
    };
    const read = text => {
      try {
        return JSON.parse(text);
      } catch { return {}; }
    };  // half of an answer is none
    const listen = place => {
      if (place === known) return;
      known = place;
      new MutationObserver(() => {
        const answer = read(place.textContent);
        if (due && answer?.id === due.id) taken(answer);
      }).observe(place, {childList: true, characterData: true, subtree: true});
    };
    const alone = () => (spare ??= start(taken))(due);
    const ask = (job, tries = 0) => {
      if (due !== job) return;
      const [question, place] =
        [".sos-question textarea", ".sos-answer"].map(where => home.querySelector(where));
      if (question && place) {
        listen(place);
        question.value = JSON.stringify(job);
        question.dispatchEvent(new Event("input", {bubbles: true}));
        timer = setTimeout(alone, 1000 * (job.request?.law ? LONG : PATIENCE));
      } else if (tries < ATTEMPTS) setTimeout(() => ask(job, tries + 1), 100);
      else alone();
    };
    return job => {
      due = job;
      ask(job);
    };
  };
}
